/**
 * Reports passed from phone to phone without a server, as codes on a screen that the other's camera reads. Reports keep the ids that their
 * writer's phone made: whoever comes into reach first delivers them, and each counts once.
 */

import { NOTE_KINDS } from "../console/note_kinds.js";
import { crc16 } from "./bytes.js";

/** @import {Report} from "./outbox.js" */

const NAME = "WAYMARK1";
const CHUNK = 280; // characters: a code that a phone reads off another's screen at once
const MOST_BYTES = 200_000;
const MOST_REPORTS = 500;
/** What a report of each kind may say. @type {Record<string, string[]>} */
const SAYS = {
  note: ["note", "text", "tag_id"],
  victim: ["tag_id", "text", "live", "dead", "start"],
  mayday: ["text", "tag_id"],
  heard: ["since_unix_s"],
  at: ["tag_id", "from_tag", "after_s", "steps_m"],
};
const LONGEST_NAME = 60;

/** Texts to show as codes, one after the other and again from the first. @param {Report[]} reports @returns {Promise<string[]>} */
export async function framesOf(reports) {
  const said = reports.filter(({ kind }) => kind in SAYS).slice(0, MOST_REPORTS).map(({ id, mission_id, kind, body, made_by, phone_unix_s, offset_s }) =>
    ({ id, mission_id, kind, body, made_by, phone_unix_s, offset_s }));
  const bytes = await through(new CompressionStream("deflate-raw"), JSON.stringify({ now_s: Date.now() / 1000, reports: said }));
  const whole = btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ""));
  const count = Math.ceil(whole.length / CHUNK);
  const name = crc16(bytes).toString(16);
  return Array.from({ length: count }, (_, k) => `${NAME}:${name}:${k}:${count}:${whole.slice(k * CHUNK, (k + 1) * CHUNK)}`);
}

/** Puts codes together that are seen in any order, some of them again and again. */
export class Collector {
  constructor() {
    this.name = "";
    /** @type {Map<number, string>} */ this.parts = new Map();
    this.count = 0;
  }

  /** @param {string} text of a code @returns {boolean} whether it is one of these codes */
  take(text) {
    const found = /^WAYMARK1:([0-9a-f]{1,4}):(\d{1,4}):(\d{1,4}):([A-Za-z0-9+/=]+)$/.exec(text);
    if (!found) return false;
    const [, name, k, count, part] = found;
    if (name !== this.name || Number(count) !== this.count) Object.assign(this, { name, count: Number(count), parts: new Map() });
    if (Number(k) < this.count) this.parts.set(Number(k), part);
    return true;
  }

  get isWhole() {
    return this.count > 0 && this.parts.size === this.count;
  }

  /** The reports, by this phone's clock where their writer's phone did not know the server's. @returns {Promise<Report[]>} @throws {Error} they are damaged */
  async reports() {
    const whole = Array.from({ length: this.count }, (_, k) => this.parts.get(k)).join("");
    const bytes = Uint8Array.from(atob(whole), (letter) => letter.charCodeAt(0));
    if (crc16(bytes).toString(16) !== this.name) throw new Error("the codes do not fit together");
    const said = JSON.parse(new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes, MOST_BYTES)));
    const behind_s = Date.now() / 1000 - Number(said.now_s);
    if (!Array.isArray(said.reports) || !Number.isFinite(behind_s)) throw new Error("these are no reports");
    return said.reports.slice(0, MOST_REPORTS).filter(isReport).map((/** @type {Report} */ report) => ({
      id: report.id, n: 0, mission_id: report.mission_id, kind: report.kind, body: report.body, made_by: report.made_by, is_carried: true,
      phone_unix_s: report.phone_unix_s + (report.offset_s === null ? behind_s : 0), offset_s: report.offset_s, tries: 0, due_ms: 0,
      refused: "", is_kept: true,
    }));
  }
}

/** @param {any} report */
function isReport(report) {
  const { id, kind, mission_id, made_by, phone_unix_s, offset_s, body } = report ?? {};
  return /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/.test(id) && Object.hasOwn(SAYS, kind) && typeof mission_id === "string"
    && typeof made_by === "string" && made_by.length <= LONGEST_NAME && Number.isFinite(phone_unix_s)
    && (offset_s === null || Number.isFinite(offset_s)) && body !== null && typeof body === "object"
    && Object.keys(body).every((name) => SAYS[kind].includes(name)) && (kind !== "note" || Object.hasOwn(NOTE_KINDS, body.note))
    && ["text", "tag_id"].every((name) => typeof (body[name] ?? "") === "string");
}

/** @param {CompressionStream | DecompressionStream} stream @param {string | Uint8Array<ArrayBuffer>} data @param {number} [most] bytes: what swells beyond is no report */
async function through(stream, data, most = Infinity) {
  const reader = new Blob([data]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let size = 0;
  for (let read = await reader.read(); !read.done; read = await reader.read()) {
    size += read.value.length;
    if (size > most) throw new Error("these are no reports");
    parts.push(read.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}
