/** Asking the server, whether it is in reach, who is logged in, and what time it has: a phone's clock may be days off. */

import { say } from "./texts.js";

/** @typedef {{name: string, role: string}} Me */

const TIMEOUT_MS = 8000; // without a byte: a slow network may take its time
const OFFSET = "waymark.offset";
const ME = "waymark.me";

/** What found no room in the storage: it is known until the page is closed. @type {Map<string, any>} */
const unkept = new Map();

/** @param {string} name @returns {any} what was remembered last, null if nothing */
export function remembered(name) {
  if (unkept.has(name)) return unkept.get(name);
  try {
    return JSON.parse(localStorage.getItem(name) ?? "null");
  } catch {
    return null;
  }
}

/** @param {string} name @param {unknown} value as JSON has it; null for nothing any more */
export function remember(name, value) {
  try {
    localStorage.setItem(name, JSON.stringify(value));
    unkept.delete(name);
  } catch {
    unkept.set(name, value);
  }
}

export const reach = {
  /** Whether the last request was answered; null before the first. @type {boolean | null} */ inReach: null,
  isLoggedOut: false,
  /** Who logged in here last: what is written is signed with that name. @type {Me | null} */ me: remembered(ME),
  /** The server's time less this phone's, in seconds; null until it has answered once. @type {number | null} */
  offset_s: remembered(OFFSET),
};

/** @type {(() => void)[]} */
const watchers = [];

/** @param {() => void} watch called when something of the above has changed */
export function onReach(watch) {
  watchers.push(watch);
}

/** @param {Partial<typeof reach>} change */
function note(change) {
  const isNew = Object.entries(change).some(([name, value]) => reach[/** @type {keyof typeof reach} */ (name)] !== value);
  Object.assign(reach, change);
  if (isNew) for (const watch of watchers) watch();
}

/** The server's time in Unix seconds, as far as this phone knows it. */
export const now_s = () => Date.now() / 1000 + (reach.offset_s ?? 0);

/**
 * @param {string} method
 * @param {string} path under /api/v1
 * @param {{body?: BodyInit, headers?: Record<string, string>}} [more]
 * @param {number} [timeout_ms]
 * @returns {Promise<Response | null>} the answer, whatever its status; null when there was none
 */
export async function ask(method, path, more = {}, timeout_ms = TIMEOUT_MS) {
  const sent_ms = Date.now();
  const silence = new Silence(timeout_ms);
  try {
    const response = silence.watch(await fetch(`/api/v1${path}`, { method, ...more, signal: silence.signal }));
    learnTime(response.headers.get("Date"), sent_ms);
    note({ inReach: response.status < 502, isLoggedOut: response.status === 401 || (reach.isLoggedOut && response.status === 403) });
    return response.status < 502 ? response : null;
  } catch {
    silence.stop();
    note({ inReach: false });
    return null;
  }
}

/** Gives up a request once nothing has come for a time, however long the whole takes. */
class Silence {
  /** @param {number} longest_ms */
  constructor(longest_ms) {
    this.over = new AbortController();
    this.longest_ms = longest_ms;
    this.timer = 0;
    this.wait();
  }

  get signal() {
    return this.over.signal;
  }

  wait() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.over.abort(), this.longest_ms);
  }

  stop() {
    clearTimeout(this.timer);
  }

  /** @param {Response} response @returns {Response} the same, whose every byte is waited for anew */
  watch(response) {
    const { body, status, statusText, headers } = response;
    if (!body) {
      this.stop();
      return response;
    }
    this.wait();
    const watched = body.pipeThrough(new TransformStream({
      transform: (bytes, onwards) => {
        this.wait();
        onwards.enqueue(bytes);
      },
      flush: () => this.stop(),
    }));
    return new Response(watched, { status, statusText, headers });
  }
}

/** The header has whole seconds: half of one is added, and only what is off by more is learnt. @param {string | null} date @param {number} sent_ms */
function learnTime(date, sent_ms) {
  const server_ms = Date.parse(date ?? "") + 500;
  if (Number.isNaN(server_ms)) return;
  const offset_s = (server_ms - (sent_ms + Date.now()) / 2) / 1000;
  if (reach.offset_s !== null && Math.abs(offset_s - reach.offset_s) < 1) return;
  note({ offset_s });
  remember(OFFSET, offset_s);
}

/** Of when an answer is, by the server's clock. @param {Response} response @returns {number} Unix seconds */
export const asOf = (response) => Number(response.headers.get("Waymark-As-Of") ?? now_s());

/** @param {string} path @returns {Promise<any>} the JSON of a good answer, else null */
export async function read(path) {
  const response = await ask("GET", path);
  return response?.ok ? response.json().catch(() => null) : null;
}

/** What a refusal means here, by its code. @type {Record<string, import("./texts.js").Key>} */
const REFUSALS = {
  mission_closed: "refused_over", mission_archived: "refused_over", unknown_mission: "refused_mission", role_too_low: "refused_role",
  too_large: "refused_large", invalid: "refused_invalid",
};

/** Why the server will not have something, in the phone's language where the reason is a common one. @param {Response} response @returns {Promise<string>} */
export async function reasonOf(response) {
  const { error } = (await response.json().catch(() => null)) ?? {};
  return say(REFUSALS[error?.code] ?? "refused_otherwise", { reason: String(error?.message ?? response.status) });
}

/** Ask who is logged in. */
export async function askWho() {
  const me = await read("/session");
  if (!me) return;
  note({ me: { name: me.name, role: me.role }, isLoggedOut: false });
  remember(ME, reach.me);
}

/** @param {string} missionId */
export const missionPath = (missionId) => `/missions/${encodeURIComponent(missionId)}`;
