/**
 * Hears radio nodes by Web Bluetooth where the browser lets a page listen (Chrome, behind a switch): a node calls out its
 * name, "WM:" and its tag id. Everything is worked out on the phone; nothing is asked of the server.
 */

import { html } from "../console/vendor.js";
import { sinceTag } from "./between.js";
import { fixText } from "./fix_words.js";
import { groundOf } from "./ground.js";
import { heardOf, sharedOf } from "./hearing.js";
import { locate } from "./locating.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

const PREFIX = "WM:";
const KEPT_MS = 5000; // who walks is elsewhere after that
const MOST = 20; // signals of a node
const EVERY_MS = 1500;

/** @type {any} */
const bluetooth = /** @type {any} */ (navigator).bluetooth;
/** @type {Map<string, {rssi: number, ms: number}[]>} */
const signals = new Map();
let scan = /** @type {any} */ (null);
let trouble = "";
let timer = 0;

/** @param {any} event */
function heard({ name, device, rssi }) {
  const called = name ?? device?.name ?? "";
  if (!called.startsWith(PREFIX) || !Number.isFinite(rssi)) return;
  const kept = signals.get(called.slice(PREFIX.length)) ?? [];
  kept.push({ rssi, ms: performance.now() });
  signals.set(called.slice(PREFIX.length), kept.slice(-MOST));
}

/** The browser asks its owner first, and only at a touch. */
async function listen() {
  trouble = "";
  try {
    scan = await bluetooth.requestLEScan({ filters: [{ namePrefix: PREFIX }], keepRepeatedDevices: true });
    bluetooth.addEventListener("advertisementreceived", heard);
    timer = setInterval(look, EVERY_MS);
  } catch {
    trouble = say("listen_refused");
  }
  changed();
}

function stop() {
  scan?.stop();
  scan = null;
  clearInterval(timer);
  bluetooth.removeEventListener("advertisementreceived", heard);
  signals.clear();
  changed({ fix: null });
}

/** Work out where the phone is by what was heard lately. */
export function look() {
  const now = performance.now();
  const lately = new Map([...signals].map(([id, kept]) => [id, kept.filter(({ ms }) => now - ms < KEPT_MS).map(({ rssi }) => rssi)]));
  for (const [id, rssis] of lately) if (!rssis.length) lately.delete(id);
  const { pocket } = state;
  if (!pocket || !lately.size) return changed({ fix: null });
  const { heard: ranges, unknown } = heardOf(pocket, lately);
  const found = locate(ranges, sharedOf(pocket.radio), sinceTag(), groundOf(pocket));
  changed({ fix: found && { ...found, text: fixText(found, pocket.tags, unknown, pocket.x_axis_deg ?? null) } });
}

/** Finding oneself by nodes, where this browser can. */
export function Nodes() {
  if (typeof bluetooth?.requestLEScan !== "function" || !state.pocket?.tags.length) return null;
  if (!scan) return html`<button type="button" onClick=${listen}>${say("listen")}</button>${trouble && html`<p class="trouble" role="alert">${trouble}</p>`}`;
  return html`<p class="where" role="status">${state.fix?.text || say("listening")}</p>
    <button type="button" onClick=${stop}>${say("listen_stop")}</button>`;
}
