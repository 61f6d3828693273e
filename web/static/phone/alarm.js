/** Help and orders that concern everybody: MAYDAY, and EVACUATE. */

import { HoldButton } from "../console/hold_button.js";
import { AGAIN_MS, allowSound, sound } from "../console/tones.js";
import { html } from "../console/vendor.js";
import { orderIn, takeAnswer } from "./evacuate.js";
import { add, sendNow, waiting } from "./outbox.js";
import { going, isOver } from "./pockets.js";
import { missionPath, now_s, reach, read, remember, remembered } from "./reach.js";
import { timeOf } from "./report_words.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";
import { lastTag } from "./touch.js";

const LOOK_EVERY_MS = 5000;
const HIDDEN_EVERY_MS = 15_000; // browsers allow no more than once a minute after some minutes, and nothing once the phone sleeps
const THREE_SHORT_MS = [500, 250, 500, 250, 500];
const OLD_S = 120;
const HEARD = "waymark.heard";

/** The mission of the tag read last; where there is none, or it is over, all that go on: somebody has to hear. */
function missionsHere() {
  const own = state.where?.mission_id || lastTag()?.mission || "";
  return own && !isOver(own) ? [own] : [...new Set(own ? [own, ...going()] : going())];
}

const order = () => orderIn(missionsHere());

/** What was called on this phone and the server does not have. */
const unsent = () => waiting().filter(({ kind, is_carried }) => kind === "mayday" && !is_carried);

async function callMayday() {
  const last = lastTag();
  const tag_id = last?.tag ?? null;
  if (unsent().some(({ body }) => body.tag_id === tag_id)) return void sendNow(true);
  const ago_s = last ? Date.now() / 1000 - last.since_s : 0;
  const text = ago_s > OLD_S ? `that tag was read ${Math.round(ago_s / 60)} min ago` : "";
  const missions = missionsHere();
  changed({ called: { mission: missions[0], at_s: now_s(), noted_by: "" } });
  await Promise.all(missions.map((mission) => add("mayday", mission, { text, tag_id })));
}

/** Whether somebody has taken note of what was called, or ended it. */
async function lookForHelp() {
  const { called } = state;
  const name = reach.me?.name;
  if (!called || !name || unsent().length) return;
  const found = await read(`${missionPath(called.mission)}/alerts`);
  if (!found || state.called !== called || unsent().length) return;
  /** @type {{alert_id: string, acknowledged_by: string, over_unix_s: number | null} | undefined} */
  const alert = found.alerts.find((/** @type {{alert_id: string}} */ { alert_id }) => alert_id === `mayday:${name}` || alert_id.startsWith(`mayday:${name} (`));
  changed({ called: alert && alert.over_unix_s === null ? { ...called, noted_by: alert.acknowledged_by } : null });
}

let timer = 0;
let isLooking = false;
let sounded_ms = 0;

/** Look for EVACUATE now and every few seconds, out of sight too as far as the browser lets it. */
export async function lookForOrders() {
  if (isLooking) return;
  isLooking = true;
  clearTimeout(timer);
  await lookForHelp();
  for (const mission of missionsHere()) {
    const found = await read(`${missionPath(mission)}/evacuation`);
    if (found) takeAnswer(mission, found);
  }
  changed();
  warn();
  isLooking = false;
  timer = setTimeout(lookForOrders, document.visibilityState === "visible" ? LOOK_EVERY_MS : HIDDEN_EVERY_MS);
}

/** Three short signals, again and again until it was heard. */
function warn() {
  const now = order();
  if (!now || isHeard(now) || Date.now() - sounded_ms < AGAIN_MS) return;
  sounded_ms = Date.now();
  navigator.vibrate?.(THREE_SHORT_MS);
  sound("evacuate");
}

/** Begin to look for orders, and be allowed to sound from the first touch on. */
export function listenForOrders() {
  lookForOrders();
  document.addEventListener("visibilitychange", lookForOrders);
  addEventListener("pointerup", allowSound, { once: true });
  addEventListener("keyup", allowSound, { once: true });
}

/** @param {import("./types.js").Evacuation} now */
const isSent = (now) => now.acknowledged.some(({ name }) => name === reach.me?.name);

/** Which order was heard here: another one has to be heard again. @param {import("./types.js").Evacuation} now */
const isHeard = (now) => isSent(now) || remembered(HEARD) === now.since_unix_s;

async function hear() {
  const now = order();
  if (!now) return;
  remember(HEARD, now.since_unix_s);
  await add("heard", now.mission, { since_unix_s: now.since_unix_s });
  changed();
}

export function Alarm() {
  const now = order();
  if (!now) return null;
  return html`<div class="alarm" role="alert"><span>${say("evacuate", { by: now.by })}</span>
    ${!isHeard(now) && html`<button type="button" onClick=${hear}>${say("i_have_heard")}</button>`}
    ${isHeard(now) && waiting().some(({ kind, is_carried }) => kind === "heard" && !is_carried) && html`<span>${say("heard_waits")}</span>`}</div>`;
}

/** One sentence as long as it is so, whatever each try meets. @param {import("./outbox.js").Report} report */
function whyUnsent({ refused, tries, phone_unix_s, offset_s }) {
  if (refused) return say("mayday_refused", { reason: refused });
  if (reach.isLoggedOut) return say("mayday_logged_out");
  return tries || reach.inReach === false ? say("mayday_not_yet", { time: timeOf(phone_unix_s + (offset_s ?? 0)) }) : say("mayday_sending");
}

export function Mayday() {
  if (!missionsHere().length) return reach.inReach !== null && html`<p class="warned">${say("mayday_none")}</p>`;
  const [first] = unsent();
  const { called } = state;
  const standing = first ? html`<p class="alarm" role="alert">${whyUnsent(first)}</p>`
    : called && html`<p role="status"><b>${say(called.noted_by ? "mayday_noted" : "mayday_called", { time: timeOf(called.at_s), by: called.noted_by })}</b></p>`;
  const label = say(first || called ? "mayday_again" : "mayday_hold");
  return html`${standing}<${HoldButton} label=${label} name=${label} kind="mayday" how=${say("press_and_hold")} longer=${say("press_longer")}
    onFire=${callMayday} />`;
}
