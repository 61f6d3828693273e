/** Words that others left in a tag, carried on to the server by whoever reads them: by an id that anyone makes the same, so each counts once. */

import { NOTE_KINDS } from "../console/note_kinds.js";
import { authorOf, notesOfPhones } from "./chip_writer.js";
import { adopt } from "./outbox.js";
import { reach } from "./reach.js";
import { missionId } from "./state.js";

const SPACE = "6d0f1a2e6a574b0e9c1b5e2f0c7d3a91"; // as server/mission/chip_notes.py
const WORD = new RegExp(`^(${Object.keys(NOTE_KINDS).join("|")}): ?([\\s\\S]*)$`);

/** @param {string} tagId @param {Uint8Array} payload of our record on its chip */
export async function carryOn(tagId, payload) {
  const mission_id = missionId();
  const others = notesOfPhones(payload).filter(({ author }) => !reach.me || author !== authorOf(reach.me.name));
  if (!mission_id || !crypto.subtle) return;
  const reports = await Promise.all(others.map(async ({ author, text }) => {
    const [, note, rest] = WORD.exec(text) ?? ["", "note", text];
    return { id: await idOf(tagId, author, text), n: 0, mission_id, kind: "note", body: { note, text: rest, tag_id: tagId }, made_by: author,
      phone_unix_s: Date.now() / 1000, offset_s: reach.offset_s, tries: 0, due_ms: 0, refused: "", is_kept: true };
  }));
  if (reports.length) await adopt(reports);
}

/** A name-based UUID (RFC 4122, version 5). @param {string} tagId @param {string} author @param {string} text */
export async function idOf(tagId, author, text) {
  const space = Uint8Array.from(SPACE.match(/../g) ?? [], (pair) => parseInt(pair, 16));
  const name = new TextEncoder().encode(`${tagId}\0${author}\0${text}`);
  const hash = new Uint8Array(await crypto.subtle.digest("SHA-1", new Uint8Array([...space, ...name]))).slice(0, 16);
  hash[6] = (hash[6] & 0x0f) | 0x50;
  hash[8] = (hash[8] & 0x3f) | 0x80;
  const digits = [...hash].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  return [0, 8, 12, 16, 20].map((from, k) => digits.slice(from, [8, 12, 16, 20, 32][k])).join("-");
}
