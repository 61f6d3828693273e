/** The live stream of one mission: a snapshot, then changes; it comes back by itself and says when it is stale. */

import { ApiError, missionPath, request } from "./api.js";

/** @import {Store} from "./store.js" */

const STALE_MS = 3000; // the server sends something each second
const GIVE_UP_MS = 8000; // an open socket silent for so long is dead
const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 8000;

export class Stream {
  /**
   * @param {Store} store
   * @param {string} missionId
   * @param {(text: string) => void} onAlarm
   */
  constructor(store, missionId, onAlarm) {
    this.store = store;
    this.missionId = missionId;
    this.onAlarm = onAlarm;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.closed = false;
    this.timer = 0;
    this.openedAt = 0;
    this.watchdog = setInterval(() => this.#watch(), 250);
    this.#open();
  }

  close() {
    this.closed = true;
    clearInterval(this.watchdog);
    clearTimeout(this.timer);
    this.#drop();
  }

  /** Try again now, without waiting for the next attempt. */
  retry() {
    clearTimeout(this.timer);
    this.#drop();
    this.#open();
  }

  #drop() {
    if (!this.socket) return;
    this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
    this.socket = null;
  }

  #open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.openedAt = Date.now();
    this.store.connection.retryAt = 0;
    const socket = new WebSocket(`${scheme}://${location.host}/api/v1${missionPath(this.missionId)}/stream`);
    socket.onmessage = (event) => this.#receive(event.data);
    socket.onclose = () => this.#lost();
    this.socket = socket;
  }

  /** @param {string} data */
  #receive(data) {
    const { store } = this;
    let message;
    try {
      message = JSON.parse(data);
    } catch {
      store.notify("A message of the live stream could not be read. If this repeats, reload the page.");
      return;
    }
    const offset_s = message.server_unix_s - Date.now() / 1000;
    if (message.type === "snapshot") {
      store.clearBoard();
      store.clockOffset_s = offset_s;
      store.apply(message.state, []);
    } else if (message.type === "changes") {
      // The least delayed message tells the offset best.
      store.clockOffset_s = Math.max(store.clockOffset_s - 1e-4, offset_s);
      store.apply(message.set, message.delete);
      for (const [key, value] of Object.entries(message.set)) {
        if (key.startsWith("event/") && value.severity === "alarm") this.onAlarm(value.text);
      }
    }
    // A message that was long under way (a choked link, a browser out of breath) is as old as it is, not new.
    const lag_ms = Math.max(0, 1000 * (store.serverNow() - message.server_unix_s));
    store.connection = {
      state: lag_ms > STALE_MS ? "stale" : "live", heardAt: Date.now() - lag_ms, attempt: 0, retryAt: 0,
      reason: lag_ms > STALE_MS ? "The data arrives late." : "",
    };
    store.changed();
  }

  #lost() {
    if (this.closed) return;
    this.socket = null;
    const { connection } = this.store;
    connection.attempt += 1;
    const wait_ms = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** (connection.attempt - 1));
    connection.retryAt = Date.now() + wait_ms * (0.8 + 0.4 * Math.random());
    if (connection.state === "live" || connection.state === "loading") connection.state = "reconnecting";
    this.timer = setTimeout(() => this.#open(), connection.retryAt - Date.now());
    this.store.changed();
    this.#askWhy();
  }

  /** A refused socket does not say why: the mission's address does. */
  async #askWhy() {
    const { connection } = this.store;
    try {
      await request("GET", missionPath(this.missionId));
      connection.reason = "The live stream broke off.";
    } catch (error) {
      connection.reason = error instanceof ApiError ? error.message : String(error);
      if (error instanceof ApiError && error.status === 404 && !this.closed) {
        this.close();
        connection.state = "failed";
      }
    }
    this.store.changed();
  }

  #watch() {
    const { connection } = this.store;
    const silent_ms = Date.now() - connection.heardAt;
    if (silent_ms > STALE_MS && (connection.state === "live" || connection.state === "reconnecting")) {
      connection.state = "stale";
      connection.reason ||= "Nothing was heard from the server.";
      this.store.changed();
    }
    if (this.socket && silent_ms > GIVE_UP_MS && Date.now() - this.openedAt > GIVE_UP_MS) {
      this.#drop();
      this.#lost();
    }
  }
}
