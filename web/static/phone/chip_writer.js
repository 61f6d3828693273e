/**
 * A word left in a tag's chip beside what robots keep there. As robots/tags/record.py and marks.py: a record of notes alone, without the
 * mission's seal, which is not on phones: robots hand it on and people read it, nobody steers by it. What robots sealed stays as it is.
 */

import { crc16, crc32, Reader } from "./bytes.js";
import { recordsIn } from "./memory.js";
import { readNotes } from "./memory_parts.js";

/** @typedef {{number: number, author: string, text: string}} Note */

const RECORD_VERSION = 3;
const HEAD = 7;
const SEAL = 8;
const NOTES_ALONE = 0x42;
const TWO_HALVES_FROM = 252; // bytes of payload: a chip of 504 bytes and more, whose record lies in halves written in turn
const MOST_NOTES = 64;

/** The chip holds what this phone cannot read, or has no room: nothing was written. */
export class ChipRefusal extends Error {
  /** @param {"unreadable" | "full"} why */
  constructor(why) {
    super(why);
    this.why = why;
  }
}

/**
 * The payload with a note added; of the same length, and with every sealed record in it untouched.
 * @param {Uint8Array} payload of our record on the chip
 * @param {string} author
 * @param {string} text
 * @returns {Uint8Array}
 * @throws {ChipRefusal}
 */
export function withNote(payload, author, text) {
  const size = payload.length >= TWO_HALVES_FROM ? payload.length >> 1 : payload.length;
  const halves = [payload.subarray(0, size), ...(size < payload.length ? [payload.subarray(size, 2 * size)] : [])].map(halfOf);
  if (halves.every(({ records }) => !records.length) && payload.some((byte) => byte !== 0)) throw new ChipRefusal("unreadable");
  const records = halves.flatMap((half) => half.records);
  const notes = records.flatMap(({ content }) => notesIn(content));
  const own = records.filter(({ isSealed }) => !isSealed).flatMap(({ content }) => notesIn(content));
  const number = Math.min(65535, 1 + Math.max(0, ...notes.map((note) => note.number)));
  const added = { number, author: authorOf(author), text: cut(text, 120) };
  const revision = (1 + Math.max(-1, ...records.map((record) => record.revision))) & 0xffff;
  const record = recordOf(packed([added, ...own]), revision);
  return placed(payload, halves, size, record);
}

/** What phones left on a chip, beside what robots sealed. @param {Uint8Array} payload @returns {Note[]} */
export function notesOfPhones(payload) {
  const halves = [payload, payload.subarray(payload.length >> 1)].flatMap(recordsIn);
  const notes = halves.filter(({ isSealed }) => !isSealed).flatMap(({ content }) => notesIn(content));
  return [...new Map(notes.map((note) => [`${note.author}\0${note.text}`, note])).values()];
}

/** @import {Found} from "./memory.js" */
/** @typedef {{records: Found[], sealed: number}} Half the whole records in it, and where what robots sealed ends */

/** @param {Uint8Array} data @returns {Half} */
function halfOf(data) {
  const records = recordsIn(data);
  const first = records[0];
  return { records, sealed: first?.isSealed ? lengthOf(first) : 0 };
}

/** @param {Found} record */
const lengthOf = ({ content }) => HEAD + content.length + SEAL;

/** Behind a sealed record where there is room, the newest first; else where no sealed record is. @param {Uint8Array} payload @param {Half[]} halves @param {number} size @param {Uint8Array} record */
function placed(payload, halves, size, record) {
  const able = halves.map((half, k) => ({ k, ...half })).filter(({ sealed }) => sealed + record.length <= size);
  const found = able.sort((a, b) => Number(b.sealed > 0) - Number(a.sealed > 0) || b.k - a.k)[0];
  if (!found) throw new ChipRefusal("full");
  const after = payload.slice();
  halves.forEach(({ records, sealed }, k) => { // an older record of notes is taken over into the new one
    if (records.some(({ isSealed }) => !isSealed)) after.fill(0, k * size + sealed, (k + 1) * size);
  });
  after.set(record, found.k * size + found.sealed);
  return after;
}

/** @param {Uint8Array} content @returns {Note[]} */
function notesIn(content) {
  if (!content.length || !(content[0] & 2)) return [];
  const reader = new Reader(content);
  if (reader.u8() & 1) reader.bytes(9 * reader.u8()); // victims
  return readNotes(reader).notes;
}

/** Content of notes alone, in the order that tags keep: the newest first. @param {Note[]} notes */
function packed(notes) {
  const inOrder = [...notes].sort((a, b) => b.number - a.number || keyOf(b) - keyOf(a)).slice(0, MOST_NOTES);
  const bytes = [NOTES_ALONE, inOrder.length, 0, 0, 0, 0, 0];
  for (const { number, author, text } of inOrder) {
    bytes.push(number >> 8, number & 255);
    for (const part of [author, text].map((each) => new TextEncoder().encode(each))) bytes.push(part.length, ...part);
  }
  return bytes;
}

/** @param {Note} note */
const keyOf = ({ author, text }) => crc32(`${author}\0${text}`) & 0xffff;

/** A record without a seal. @param {number[]} content @param {number} revision */
function recordOf(content, revision) {
  const head = [RECORD_VERSION, revision >> 8, revision & 255, content.length >> 8, content.length & 255];
  const rest = [...content, ...new Array(SEAL).fill(0)];
  const check = crc16([...head, ...rest]);
  return Uint8Array.from([...head, check >> 8, check & 255, ...rest]);
}

/** As much of a name as a note has room for. @param {string} name */
export const authorOf = (name) => cut(name, 16);

/** The beginning of a text that has so many bytes at most, no character cut. @param {string} text @param {number} most */
function cut(text, most) {
  const bytes = new Uint8Array(most);
  const { read } = new TextEncoder().encodeInto(text, bytes);
  return text.slice(0, read);
}
