/**
 * The mission as it was: which moment is looked at, and the board of that moment.
 *
 * The past comes in chunks: the whole state at their beginning, then what changed. Moments lie on an axis without the
 * stretches in which nothing was recorded.
 */

import { missionPath, request } from "./api.js";
import { BoardState } from "./board_state.js";
import { Axis } from "./time_axis.js";

/** @import {Store} from "./store.js" */

/**
 * @typedef {{unix_s: number, set: Record<string, any>, patch: Record<string, any>,
 *   splice: Record<string, Record<string, [number, number, unknown[]]>>, delete: string[]}} Change
 * @typedef {{begins_unix_s: number, state: Record<string, any>, changes: Change[]}} Chunk
 * @typedef {{number: number, begins_unix_s: number, ends_unix_s: number}} Span
 */

const KEPT = 60; // chunks, half a minute each
const INDEX_MS = 5000;
const FRAME_MS = 100;
export const SPEEDS = [1, 2, 5, 10, 30, 60];

export class Past {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    /** The moment that is looked at, null while it is now. @type {number | null} */
    this.at_s = null;
    /** What was shown then. @type {BoardState | null} */
    this.board = null;
    /** @type {Span[]} */
    this.spans = [];
    this.axis = new Axis([]);
    this.isPlaying = false;
    this.speed = 1;
    this.trouble = "";
    /** When the operator left the present. */
    this.left_s = 0;
    /** @type {Map<number, Promise<Chunk>>} */
    this.chunks = new Map();
    /** What the board was made of: chunk, and how many of its changes. @type {{number: number, done: number} | null} */
    this.made = null;
    /** @type {Record<string, any>} */
    this.state = {};
    this.timer = 0;
    this.indexed_ms = -Infinity;
    this.missionId = "";
  }

  /** Forget everything: another mission begins, live. @param {string} missionId */
  clear(missionId) {
    this.live();
    this.missionId = missionId;
    this.spans = [];
    this.axis = new Axis([]);
    this.chunks.clear();
    this.indexed_ms = -Infinity;
    this.refresh();
  }

  /** Learn which chunks there are, every few seconds. */
  async refresh() {
    if (!this.missionId || performance.now() - this.indexed_ms < INDEX_MS) return;
    this.indexed_ms = performance.now();
    const { missionId } = this;
    try {
      const { chunks } = await request("GET", `${missionPath(missionId)}/history`);
      if (missionId !== this.missionId) return;
      const last = this.spans.at(-1);
      // What was the last one has grown since.
      if (last && last.ends_unix_s !== chunks[this.spans.length - 1]?.ends_unix_s) this.chunks.delete(last.number);
      this.spans = chunks;
      this.axis = new Axis(chunks);
      this.store.changed();
    } catch {
      // The bar stays as it is; the stream says when the server is away.
    }
  }

  /** Go to a moment. @param {number} unix_s */
  seek(unix_s) {
    if (!this.spans.length) return;
    if (this.at_s === null) {
      this.left_s = this.store.serverNow();
      this.store.best.showLive();
      this.store.picking = this.store.draft = null;
    }
    this.at_s = Math.min(Math.max(unix_s, this.axis.begins_s), this.axis.ends_s);
    this.#show();
    this.store.changed();
  }

  /** Go so many seconds on, or back. @param {number} seconds */
  step(seconds) {
    this.pause();
    this.seek(this.axis.on(this.at_s ?? this.axis.ends_s, seconds));
  }

  /** Back to what is now. */
  live() {
    this.pause();
    this.at_s = null;
    this.board = null;
    this.made = null;
    this.trouble = "";
    this.store.changed();
  }

  play() {
    if (this.at_s === null) this.seek(this.axis.begins_s);
    if (this.at_s === null) return;
    this.isPlaying = true;
    let last = performance.now();
    clearInterval(this.timer);
    this.timer = setInterval(() => {
      const now = performance.now();
      const to = this.axis.on(this.at_s ?? 0, (this.speed * (now - last)) / 1000);
      last = now;
      if (to >= this.axis.ends_s) this.pause();
      this.seek(to);
    }, FRAME_MS);
    this.store.changed();
  }

  pause() {
    clearInterval(this.timer);
    this.isPlaying = false;
    this.store.changed();
  }

  /** Make the board of the moment that is looked at, once its chunk is there. */
  async #show() {
    const index = this.spans.findLastIndex((span) => span.begins_unix_s <= (this.at_s ?? 0));
    const span = this.spans[index];
    if (!span) return;
    try {
      const chunk = await this.#chunk(span);
      if (this.at_s === null || this.spans.findLast((each) => each.begins_unix_s <= (this.at_s ?? 0))?.number !== span.number) return;
      this.#bring(span.number, chunk);
      this.trouble = "";
      for (const next of [this.spans[index + 1], this.spans[index - 1]]) if (next) this.#chunk(next).catch(() => {});
    } catch (error) {
      this.trouble = /** @type {Error} */ (error).message;
    }
    this.store.changed();
  }

  /** @param {Span} span @returns {Promise<Chunk>} */
  #chunk({ number }) {
    const known = this.chunks.get(number);
    const chunk = known ?? request("GET", `${missionPath(this.missionId)}/history/chunks/${number}`);
    this.chunks.delete(number);
    this.chunks.set(number, chunk); // the latest used last
    if (!known) chunk.catch(() => this.chunks.delete(number));
    if (this.chunks.size > KEPT) this.chunks.delete(/** @type {number} */ (this.chunks.keys().next().value));
    return chunk;
  }

  /**
   * Bring the board to the moment: on from where it is, or from the beginning of the chunk.
   * @param {number} number
   * @param {Chunk} chunk
   */
  #bring(number, chunk) {
    const at_s = /** @type {number} */ (this.at_s);
    const isBehind = this.made?.number === number && (chunk.changes[this.made.done - 1]?.unix_s ?? 0) <= at_s;
    if (!this.made || !isBehind) {
      this.state = { ...chunk.state };
      this.board ??= new BoardState();
      this.board.clear();
      for (const [key, value] of Object.entries(this.state)) this.#put(key, value);
      this.made = { number, done: 0 };
    }
    for (; this.made.done < chunk.changes.length; this.made.done += 1) {
      const change = chunk.changes[this.made.done];
      if (change.unix_s > at_s) break;
      for (const key of apply(this.state, change)) this.#put(key, this.state[key] ?? null);
    }
  }

  /** @param {string} key @param {any} value */
  #put(key, value) {
    const png = key === "map" && value && `/api/v1${missionPath(this.missionId)}/history/maps/${value.version}.png`;
    this.board?.put(key, png ? { ...value, png } : value);
  }
}

/**
 * Bring a state to what it is after a change; values in it are replaced, not changed.
 * @param {Record<string, any>} state
 * @param {Change} change
 * @returns {string[]} the keys that differ
 */
export function apply(state, change) {
  Object.assign(state, change.set);
  for (const [key, fields] of Object.entries(change.patch)) state[key] = { ...state[key], ...fields };
  for (const [key, lists] of Object.entries(change.splice)) {
    state[key] = { ...state[key] };
    for (const [name, [front, back, middle]] of Object.entries(lists)) {
      const old = state[key][name];
      state[key][name] = [...old.slice(0, front), ...middle, ...old.slice(old.length - back)];
    }
  }
  for (const key of change.delete) delete state[key];
  return [...Object.keys(change.set), ...Object.keys(change.patch), ...Object.keys(change.splice), ...change.delete];
}
