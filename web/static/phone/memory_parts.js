/** The parts of a tag's memory: windows of cells, marks, notes and maps. As robots/tags/window.py, marks.py and map_memory.py. */

import { BytesError, crc32, Reader } from "./bytes.js";

const PER_BYTE = 5; // cells of three states
const MAX_NAME = 16;
const MAX_TEXT = 120;
const MAX_NOTES = 64;
const MAX_WRITERS = 100;
const MAX_BELIEFS = 2000;
const HAS_FRAME = 0x8000;
const SIZES_FROM = 66;

/** Bytes of the box of a window. @param {number} reach */
const boxBytes = (reach) => Math.ceil(Math.ceil(Math.log2((2 * reach + 1) ** 4)) / 8);

/**
 * A window as texts, one a row, north first and west to the left; `states` has a character for each state.
 * Its first byte tells how large cells are, too. @param {Reader} reader @param {number} most cells from the middle
 * @param {string} states
 */
export function readWindow(reader, most, states, sizes = 1) {
  const first = reader.u8();
  const size = Math.floor(first / SIZES_FROM);
  if (size >= sizes) throw new BytesError(`its cells have a size ${size} that does not exist`);
  const head = first % SIZES_FROM;
  const reach = (head >> 1) - 1;
  const holds = head % 2 === 1;
  if (reach > most || (reach === most && !holds) || (reach < 0 && holds)) throw new BytesError(`its window reaches ${reach} cells`);
  return { reach, size, rows: holds ? rowsOf(cellsIn(reader, reach), reach, states) : [states[0]] };
}

/** Cells that are not 0, by row and column. @param {Reader} reader @param {number} reach */
function cellsIn(reader, reach) {
  const side = 2 * reach + 1;
  let number = reader.bytes(boxBytes(reach)).reduce((sum, byte) => sum * 256 + byte, 0);
  const [right, left, bottom, top] = [0, 0, 0, 0].map(() => {
    const edge = number % side;
    number = Math.floor(number / side);
    return edge;
  });
  const [height, width] = [bottom - top + 1, right - left + 1];
  if (number || height < 1 || width < 1) throw new BytesError("its window has no such box");
  /** @type {{row: number, column: number, state: number}[]} */
  const cells = [];
  reader.bytes(Math.ceil((height * width) / PER_BYTE)).forEach((byte, k) => {
    if (byte > 242) throw new BytesError("a cell has a state that does not exist");
    for (let digit = 0, rest = byte; digit < PER_BYTE; digit += 1, rest = Math.floor(rest / 3)) {
      const at = k * PER_BYTE + digit;
      if (rest % 3 === 0) continue;
      if (at >= height * width) throw new BytesError("there are cells beyond its window");
      cells.push({ row: top + Math.floor(at / width), column: left + (at % width), state: rest % 3 });
    }
  });
  const edges = [Math.min(...cells.map(({ row }) => row)), Math.max(...cells.map(({ row }) => row)),
    Math.min(...cells.map(({ column }) => column)), Math.max(...cells.map(({ column }) => column))];
  if (!cells.length || [top, bottom, left, right].some((edge, k) => edge !== edges[k])) {
    throw new BytesError("its window is larger than what it holds");
  }
  return cells;
}

/** @param {{row: number, column: number, state: number}[]} cells @param {number} reach @param {string} states */
function rowsOf(cells, reach, states) {
  const far = Math.max(...cells.flatMap(({ row, column }) => [Math.abs(row - reach), Math.abs(column - reach)]));
  const rows = Array.from({ length: 2 * far + 1 }, () => new Array(2 * far + 1).fill(states[0]));
  for (const { row, column, state } of cells) rows[far + reach - row][far + reach - column] = states[state];
  return rows.map((row) => row.join(""));
}

/** Entries of one length, the greatest first, none of a key twice. @template T @param {Reader} reader @param {() => T} read @param {(entry: T) => number[]} order @returns {T[]} */
function marks(reader, read, order) {
  const count = reader.u8();
  if (!count) throw new BytesError("its marks are cut off");
  const found = Array.from({ length: count }, read);
  const keys = new Set(found.map((entry) => order(entry).at(-1)));
  const isSorted = found.slice(1).every((entry, k) => isGreater(order(found[k]), order(entry)));
  if (keys.size !== count || !isSorted) throw new BytesError("its marks are out of order");
  return found;
}

/** @param {number[]} a @param {number[]} b */
function isGreater(a, b) {
  const k = a.findIndex((number, n) => number !== b[n]);
  return k >= 0 && a[k] > b[k];
}

/** @param {Reader} reader */
export function readVictims(reader) {
  const found = marks(reader, () => {
    const [key, north, west] = [reader.u16(), reader.i16(), reader.i16()];
    return { key, north, west, confidence: reader.u8(), seen_min: reader.u16() };
  }, (v) => [v.confidence, v.seen_min, v.north, v.west, v.key]);
  return found.map(({ key, north, west, confidence, seen_min }) => (
    { key, north_m: north / 10, west_m: west / 10, confidence: Number((confidence / 255).toFixed(3)), seen_min }));
}

/** @param {Reader} reader */
export function readPasses(reader) {
  const found = marks(reader, () => {
    const [key, count, serial] = [reader.u16(), reader.u8(), reader.u8()];
    return { key, count, serial, north: reader.i8(), west: reader.i8() };
  }, (p) => [p.count, p.serial, p.north, p.west, p.key]);
  return found.map(({ key, count, serial, north, west }) => ({ key, count, serial, goal_north_m: north / 2, goal_west_m: west / 2 }));
}

/** @param {Reader} reader */
export function readNotes(reader) {
  const [count, cut] = [reader.u8(), reader.u8()];
  const gone = [reader.u16(), reader.u16()];
  if (cut > 1 || count > MAX_NOTES) throw new BytesError("its notes are damaged");
  const notes = Array.from({ length: count }, () => ({ number: reader.u16(), author: reader.text(MAX_NAME), text: reader.text(MAX_TEXT) }));
  const orders = notes.map(({ number, author, text }) => [number, crc32(`${author}\0${text}`) & 0xffff]);
  if (cut === 1) orders.push(gone);
  if (orders.slice(1).some((order, k) => !isGreater(orders[k], order))) throw new BytesError("its notes are damaged");
  return { notes, notes_let_go: cut === 1 ? gone : null };
}

/** @param {Reader} reader */
export function readMaps(reader) {
  const maps = Array.from({ length: reader.u8() }, () => {
    const robot_id = reader.text();
    const [revision, head] = [reader.u32(), reader.u16()];
    const frame = head & HAS_FRAME ? { frame: numbers(reader, 6) } : {};
    const count = head & ~HAS_FRAME;
    if (count > MAX_BELIEFS) throw new BytesError(`a map in it has ${count} tags`);
    const tags = Array.from({ length: count }, () => {
      const tag_id = reader.text();
      const [x_m, y_m, variance_x, covariance_xy, variance_y] = numbers(reader, 5);
      return { tag_id, x_m, y_m, variance_x, covariance_xy, variance_y };
    });
    return { robot_id, revision, tags, ...frame };
  });
  if (new Set(maps.map(({ robot_id }) => robot_id)).size !== maps.length || maps.length > MAX_WRITERS) {
    throw new BytesError("the maps in it are damaged");
  }
  return maps.sort((a, b) => (a.robot_id < b.robot_id ? -1 : 1));
}

/** @param {Reader} reader @param {number} count */
const numbers = (reader, count) => Array.from({ length: count }, () => reader.f32());
