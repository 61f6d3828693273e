/**
 * What robots and people left in a tag, read on the phone with no server. As robots/tags/record.py, content.py and describe.py.
 * The mission's key is not on phones, so that a lost phone cannot forge memories: whose seal it is, is not checked here.
 */

import { BytesError, crc16, Reader } from "./bytes.js";
import { readMaps, readNotes, readPasses, readVictims, readWindow } from "./memory_parts.js";
import { say } from "./texts.js";
import { compassPoint, rounded } from "./words.js";

/** @typedef {{window: string[], phase: number, cell_m: number, reach: number, visited: string[], visited_reach: number,
 *   victims: {key: number, north_m: number, west_m: number, confidence: number, seen_min: number}[],
 *   notes: {number: number, author: string, text: string}[], notes_let_go: number[] | null,
 *   passes: {key: number, count: number, serial: number, goal_north_m: number, goal_west_m: number}[],
 *   maps: {robot_id: string, revision: number, tags: object[], frame?: number[]}[]}} Memory */
/** @typedef {{condition: "empty" | "read" | "damaged" | "foreign", memory: Memory | null}} Said */

const RECORD_VERSION = 3;
const HEAD = 7;
const OVERHEAD = HEAD + 8; // the seal
const CONTENT_VERSION = 0x40;
const MAX_BYTES = 1 << 16;
const REACH = 31;
const VISITED_REACH = 10;
const CENTRED = 0x88;
const CELLS_M = [1, 0.5, 2];

/** Whole records, one after the other; what is damaged is left out. @param {Uint8Array} data */
export function recordsIn(data) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const found = [];
  for (let at = 0; data.length - at >= OVERHEAD;) {
    const end = at + OVERHEAD + view.getUint16(at + 3);
    if (data[at] !== RECORD_VERSION || end > data.length) break;
    const said = [...data.subarray(at, at + 5), ...data.subarray(at + HEAD, end)];
    if (crc16(said) === view.getUint16(at + 5)) {
      const isSealed = data.subarray(end - 8, end).some((byte) => byte !== 0); // phones have no key, and leave it out
      found.push({ revision: view.getUint16(at + 1), content: data.subarray(at + HEAD, end - 8), isSealed });
    }
    at = end;
  }
  return found;
}

/** Records in the payload of a chip, whole or in two halves written in turn; notes of phones lie behind. @param {Uint8Array} payload */
export function recordsOnChip(payload) {
  const half = payload.length >> 1;
  return [...recordsIn(payload), ...recordsIn(payload.subarray(half))];
}

/** Revisions wrap round (RFC 1982). @param {number} revision @param {number} than */
function isNewer(revision, than) {
  const ahead = (revision - than) & 0xffff;
  return ahead > 0 && ahead < 0x8000;
}

/** What a tag says. @param {Uint8Array} payload of our record on a chip @returns {Said} */
export function memoryOnChip(payload) {
  return payload.every((byte) => byte === 0) ? { condition: "empty", memory: null } : newest(recordsOnChip(payload), payload[0]);
}

/** What a reader or the server handed on. @param {Uint8Array} data records, one after the other @returns {Said} */
export function memoryIn(data) {
  return data.length ? newest(recordsIn(data), data[0]) : { condition: "empty", memory: null };
}

/** @typedef {{revision: number, content: Uint8Array, isSealed: boolean}} Found */

/** What robots sealed counts first; notes of phones come to it. @param {Found[]} records @param {number} first byte of where they were looked for @returns {Said} */
function newest(records, first) {
  if (!records.length) return { condition: first === RECORD_VERSION || first === 0 ? "damaged" : "foreign", memory: null };
  const sealed = records.filter(({ isSealed }) => isSealed);
  const { content } = (sealed.length ? sealed : records).reduce((a, b) => (isNewer(b.revision, a.revision) ? b : a));
  try {
    const memory = decodeMemory(content);
    for (const record of sealed.length ? records.filter(({ isSealed }) => !isSealed) : []) memory.notes.unshift(...decodeMemory(record.content).notes);
    return { condition: "read", memory };
  } catch (error) {
    if (!(error instanceof BytesError)) throw error;
    return { condition: content[0] >> 6 === CONTENT_VERSION >> 6 ? "damaged" : "foreign", memory: null };
  }
}

/** @param {Uint8Array} data @returns {Memory} @throws {BytesError} it is damaged, or of another version */
export function decodeMemory(data) {
  /** @type {Memory} */
  const memory = { window: ["."], phase: CENTRED, cell_m: CELLS_M[0], reach: REACH, visited: ["."], visited_reach: VISITED_REACH, victims: [], notes: [],
    notes_let_go: null, passes: [], maps: [] };
  if (!data.length) return memory;
  if (data.length > MAX_BYTES || data[0] >> 6 !== CONTENT_VERSION >> 6) throw new BytesError("it is of another version");
  const reader = new Reader(data);
  const kinds = reader.u8();
  if (kinds & 1) memory.victims = readVictims(reader);
  if (kinds & 2) Object.assign(memory, readNotes(reader));
  if (kinds & 4) memory.passes = readPasses(reader);
  if (kinds & 8) {
    const { reach, rows } = readWindow(reader, VISITED_REACH, ".12");
    Object.assign(memory, { visited_reach: reach, visited: rows });
  }
  if (kinds & 16) {
    const place = reader.u8();
    const { reach, size, rows } = readWindow(reader, REACH, ".o#", CELLS_M.length);
    Object.assign(memory, { phase: place | (size << 8), cell_m: CELLS_M[size], reach, window: rows });
  }
  if (kinds & 32) memory.maps = readMaps(reader);
  if (reader.at !== data.length) throw new BytesError(`it has ${data.length - reader.at} bytes too many`);
  return memory;
}

/** What a memory holds beside the ground, one sentence each. @param {Memory} memory @param {number | null} north true bearing of the plan's x axis */
export function sentencesOf(memory, north) {
  const said = memory.victims.map((v) => say("memory_victim", { key: hex(v.key), way: wayTo(v.north_m, v.west_m, north),
    sure: rounded(100 * v.confidence), minute: v.seen_min }));
  said.push(...memory.notes.map(({ author, text }) => say("memory_note", { author, text })));
  for (const p of memory.passes) {
    const times = p.count === 1 ? say("once") : say("times", { n: p.count });
    const way = wayTo(p.goal_north_m, p.goal_west_m, north);
    const went = p.goal_north_m || p.goal_west_m ? say("memory_went", { way }) : "";
    said.push(say("memory_pass", { key: hex(p.key), times, went }));
  }
  const driven = [...memory.visited.join("")].filter((cell) => cell !== ".").length;
  if (driven) said.push(say("memory_driven", { n: driven }));
  return [...said, ...memory.maps.map(({ robot_id, tags }) => say("memory_map", { robot: robot_id, n: tags.length }))];
}

/** @param {number} key */
const hex = (key) => key.toString(16).padStart(4, "0");

/** A memory knows the plan's axes alone. @param {number} x_m @param {number} y_m along the plan's axes @param {number | null} north */
function wayTo(x_m, y_m, north) {
  const turned = ((north ?? 0) * Math.PI) / 180;
  const [north_m, west_m] = [x_m * Math.cos(turned) + y_m * Math.sin(turned), y_m * Math.cos(turned) - x_m * Math.sin(turned)];
  return say("of_the_tag", { a: Math.abs(north_m).toFixed(1), north: compassPoint(north_m >= 0 ? 0 : 180, north), b: Math.abs(west_m).toFixed(1),
    west: compassPoint(west_m >= 0 ? 270 : 90, north) });
}
