/** Web NFC: reading tags by touching them with the phone, and leaving a word in their chips. Chrome on Android alone has it. */

import { carryOn } from "./chip_carry.js";
import { ChipRefusal, withNote } from "./chip_writer.js";
import { ask, followLink, tagOfLink } from "./meant.js";
import { chipRead } from "./memory_view.js";
import { reach } from "./reach.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

/** @typedef {import("./texts.js").Key} Key */
/** @typedef {{recordType: string, data?: DataView}} NdefRecord */

const OURS = "u.io:t";
/** @type {Record<string, Key>} */
const WHY = { NotAllowedError: "nfc_refused", NotSupportedError: "nfc_none", NotReadableError: "nfc_off" };

/** @type {any} */
let reader = null;
/** What is to be written into a tag when it is touched, whatever is touched before. @type {{tagId: string, text: string} | null} */
let toWrite = null;

export const hasNfc = () => "NDEFReader" in globalThis;
export const isReading = () => reader !== null;
/** The tag that a word is to be written into. */
export const waitsFor = () => toWrite?.tagId ?? "";

/** Begin to read every tag that is touched; the browser asks once whether it may. */
export async function readTouched() {
  if (reader) return;
  const coming = new /** @type {any} */ (globalThis).NDEFReader();
  coming.onreading = (/** @type {any} */ event) => take(event.message.records);
  coming.onreadingerror = () => ask({ trouble: say("nfc_unreadable") });
  reader = coming;
  try {
    await coming.scan();
    changed({ trouble: "" });
  } catch (error) {
    reader = null;
    changed({ trouble: say(WHY[/** @type {DOMException} */ (error)?.name] ?? "nfc_none") });
  }
}

/** Write a word into the chip of the tag one is at, when it is touched again. @param {string} text */
export async function writeNext(text) {
  toWrite = { tagId: state.tagId, text };
  await readTouched();
  if (!reader) toWrite = null;
  changed();
}

/** Leave the word out of the tag after all: it is on the phone, and goes to the server. */
export function writeNothing() {
  toWrite = null;
  changed({ trouble: "" });
}

/** @param {NdefRecord[]} records */
async function take(records) {
  const link = records.find(({ recordType }) => recordType === "url");
  const ours = records.find(({ recordType }) => recordType === OURS);
  const address = link?.data ? new TextDecoder().decode(link.data) : "";
  const tag = tagOfLink(address);
  if (!tag) {
    ask({ trouble: say(records.length ? "nfc_foreign" : "nfc_empty") });
    return;
  }
  const payload = ours?.data ? new Uint8Array(ours.data.buffer.slice(ours.data.byteOffset, ours.data.byteOffset + ours.data.byteLength)) : null;
  const read_s = Date.now() / 1000;
  const isHere = tag.host === location.host;
  const written = toWrite && isHere && tag.tagId === toWrite.tagId ? await write(toWrite, address, payload, records.length) : null;
  await followLink(address, read_s);
  if (written) changed(written);
  if (!payload || !isHere || written) return;
  chipRead(tag.tagId, payload);
  if (state.where?.tag_id === tag.tagId) await carryOn(tag.tagId, payload).catch(() => undefined); // damaged: the page says so
}

/**
 * While the chip is at the phone.
 * @param {{tagId: string, text: string}} word @param {string} address @param {Uint8Array | null} payload @param {number} count of records on the chip
 * @returns {Promise<{trouble: string, said?: string}>} what to tell of it
 */
async function write({ tagId, text }, address, payload, count) {
  if (!payload || count !== 2) { // whatever else is on it would be lost
    toWrite = null;
    return { trouble: say("nfc_not_ours") };
  }
  try {
    const after = withNote(payload, reach.me?.name ?? "?", text);
    await reader.write({ records: [{ recordType: "url", data: address }, { recordType: OURS, data: after }] }, { overwrite: true });
    toWrite = null;
    chipRead(tagId, after);
    return { trouble: "", said: say("nfc_written", { tag: tagId }) };
  } catch (error) {
    const isRefusal = error instanceof ChipRefusal;
    if (isRefusal) toWrite = null;
    return { trouble: say(!isRefusal ? "nfc_torn" : error.why === "full" ? "nfc_full" : "nfc_unreadable_here", { tag: tagId }) };
  }
}
