/** The responder's phone at a tag: where am I, who is near, the way there tag by tag, and leaving word. */

import { ApiError, missionPath, request } from "../console/api.js";
import { HoldButton } from "../console/hold_button.js";
import { newId, NOTE_KINDS } from "../console/notes.js";
import { html, render } from "../console/vendor.js";

const TARGET = "waymark.target"; // where this phone is being led
const LOOK_EVERY_MS = 5000;

/** @typedef {{mission_id: string, mission_name: string, tag_id: string, sd_m: number, notice: string, text: string,
 *   victims: {victim_id: string, status: string, distance_m: number, reachable: boolean}[]}} Where */
/** @typedef {{distance_m: number, bearing_deg: number, text: string, to_tag?: string, uncertain?: boolean}} Step */
/** @typedef {{distance_m: number, legs: Step[], last: Step | null}} Route */

const state = {
  tagId: decodeURIComponent(location.pathname.split("/")[2] ?? ""),
  /** @type {Where | null} */ where: null,
  /** @type {Route | null} */ route: null,
  trouble: "",
  /** @type {"" | "word"} */ form: "",
  said: "",
  /** Compass heading of the phone, degrees from north; null where it tells none. @type {number | null} */ heading: null,
  evacuation: /** @type {{ordered: boolean, by: string, acknowledged: {name: string}[]} | null} */ (null),
  me: /** @type {{name: string} | null} */ (null),
  called: false,
};

/** @returns {{mission: string, to: string} | null} */
function target() {
  try {
    const kept = JSON.parse(localStorage.getItem(TARGET) ?? "null");
    return kept && kept.mission === state.where?.mission_id ? kept : null;
  } catch {
    return null;
  }
}

/** @param {unknown} error */
const wordsOf = (error) => (error instanceof ApiError ? error.message : String(error));

async function load() {
  if (!state.tagId) return;
  try {
    state.where = await request("GET", `/where/${encodeURIComponent(state.tagId)}${location.search}`);
    await findWay();
  } catch (error) {
    state.trouble = wordsOf(error);
  }
  show();
}

async function findWay() {
  const goal = target();
  state.route = null;
  if (!goal || !state.where) return;
  const query = new URLSearchParams({ from: state.tagId, to: goal.to });
  state.route = await request("GET", `${missionPath(goal.mission)}/routes?${query}`);
}

/** @param {string | null} to */
async function lead(to) {
  state.trouble = "";
  if (to === null) localStorage.removeItem(TARGET);
  else localStorage.setItem(TARGET, JSON.stringify({ mission: state.where?.mission_id, to }));
  try {
    await findWay();
  } catch (error) {
    localStorage.removeItem(TARGET);
    state.trouble = wordsOf(error);
  }
  show();
  scrollTo(0, 0);
}

/** Leave word at this tag. @param {SubmitEvent} event */
async function leaveWord(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  const kind = /** @type {HTMLButtonElement} */ (event.submitter).value;
  const text = String(new FormData(form).get("text")).trim();
  const id = form.dataset.id;
  try {
    await request("PUT", `${missionPath(state.where?.mission_id ?? "")}/annotations/${id}`, { kind, text, tag_id: state.tagId });
    state.form = "";
    wordId = "";
    state.said = `${NOTE_KINDS[kind].label} left at tag ${state.tagId}.`;
    state.trouble = "";
  } catch (error) {
    state.trouble = `Not sent. ${wordsOf(error)} Try again: it is kept once however often you send it.`;
  }
  show();
}

async function mayday() {
  try {
    await request("POST", `${missionPath(state.where?.mission_id ?? "")}/alerts/mayday`, { text: "", tag_id: state.tagId });
    state.called = true;
    state.trouble = "";
  } catch (error) {
    state.trouble = `MAYDAY was NOT sent. ${wordsOf(error)}`;
  }
  show();
}

async function lookForOrders() {
  if (state.where) {
    const path = `${missionPath(state.where.mission_id)}/evacuation`;
    try {
      const found = await request("GET", path);
      state.evacuation = found.ordered ? found : null;
    } catch {
      // the next look may get through; what is shown stays
    }
    showAlarm();
  }
  setTimeout(lookForOrders, LOOK_EVERY_MS);
}

async function heard() {
  const path = `${missionPath(state.where?.mission_id ?? "")}/evacuation/acknowledge`;
  state.evacuation = await request("POST", path).catch(() => state.evacuation);
  showAlarm();
}

/** @param {number} far_m */
const far = (far_m) => `${Math.max(1, Math.round(far_m))} m`;

function Nowhere() {
  /** @param {SubmitEvent} event */
  const go = (event) => {
    event.preventDefault();
    const id = String(new FormData(/** @type {HTMLFormElement} */ (event.target)).get("id")).replace(/\s+/g, "");
    if (id) location.assign(`/t/${encodeURIComponent(id)}`);
  };
  return html`<h1>Which tag?</h1>
    ${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}
    <form onSubmit=${go}><label>The number on the tag<input name="id" autocapitalize="characters" autocomplete="off"
      spellcheck="false" maxlength="100" required /></label><button type="submit">Where am I?</button></form>`;
}

/** One arrow, one number, the next tag. @param {{route: Route, to: string}} props */
function Guide({ route, to }) {
  const step = route.legs[0] ?? route.last;
  const [kind, name] = to.split(":");
  if (!step) return html`<section class="go"><p class="next">You are there: ${kind} ${name}.</p>
    <button type="button" onClick=${() => lead(null)}>Done</button></section>`;
  const turn = step.bearing_deg - (state.heading ?? 0);
  return html`<section class="go" aria-label=${`The way to ${kind} ${name}`}>
    <p class="soft">To ${kind} ${name}, ${far(route.distance_m)} in all</p>
    <svg viewBox="0 0 100 100" role="img" aria-label=${`Arrow, ${Math.round(step.bearing_deg)} degrees from north`}>
      <g transform=${`rotate(${turn} 50 50)`}><path d="M50 6 86 80 50 64 14 80Z" fill="var(--accent)" /></g></svg>
    <p class="number">${step.uncertain ? "about " : ""}${far(step.distance_m)}</p>
    <p class="next">${step.to_tag ? `to tag ${step.to_tag}` : `to the ${kind}`}</p>
    <p class="text">${step.text}</p>
    ${state.heading === null && html`<p class="soft">The arrow points as on a map with north up.</p>`}
    ${step.to_tag && html`<a class="soft" href=${`/t/${encodeURIComponent(step.to_tag)}`}>I am at ${step.to_tag}</a>`}
    <button type="button" onClick=${() => lead(null)}>Stop leading me</button></section>`;
}

function Page() {
  const { where } = state;
  if (!where) return html`<${Nowhere} />`;
  const goal = target();
  return html`<h1>Tag ${where.tag_id}</h1>
    ${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}
    ${state.said && html`<p role="status">${state.said}</p>`}
    ${goal && state.route && html`<${Guide} route=${state.route} to=${goal.to} />`}
    <p class="where">${where.text}${where.sd_m > 1 ? ` Its place is known to ${far(where.sd_m)} only.` : ""}</p>
    ${where.notice && html`<p class="trouble">${where.notice}</p>`}
    ${where.victims.length > 0 && html`<h2>Lead me to</h2><ul>
      ${where.victims.map((victim) => html`<li key=${victim.victim_id}><button type="button" disabled=${!victim.reachable}
        onClick=${() => lead(`victim:${victim.victim_id}`)}><span>Victim ${victim.victim_id}
          <span class="soft"> ${victim.reachable ? victim.status : "no way known"}</span></span>
        <span class="far">${far(victim.distance_m)}</span></button></li>`)}</ul>`}
    ${state.form === "word" ? html`<${Word} />`
      : html`<button type="button" onClick=${() => { state.form = "word"; state.said = ""; show(); }}>Leave word here</button>`}
    <p class="soft">${where.mission_name}</p>`;
}

let wordId = "";

function Word() {
  wordId ||= newId();
  return html`<form onSubmit=${leaveWord} data-id=${wordId}><label>What is here<input name="text" maxlength="2000" /></label>
    <div class="row">${Object.entries(NOTE_KINDS).map(([kind, { label, glyph }]) => html`<button type="submit" name="kind"
      value=${kind}>${glyph} ${label}</button>`)}</div></form>`;
}

function showAlarm() {
  const { evacuation, me } = state;
  const isHeard = evacuation?.acknowledged.some(({ name }) => name === me?.name);
  render(evacuation && html`<div class="alarm" role="alert"><span>EVACUATE. Everybody out, says ${evacuation.by}.</span>
    ${!isHeard && html`<button type="button" onClick=${heard}>I have heard it</button>`}</div>`,
    /** @type {HTMLElement} */ (document.getElementById("alarm")));
}

function show() {
  document.title = `${state.tagId ? `Tag ${state.tagId}` : "Tag"} · Waymark`;
  render(html`<${Page} />`, /** @type {HTMLElement} */ (document.getElementById("page")));
  render(state.where && (state.called ? html`<p role="status"><b>MAYDAY was called. Stay where you are if you can.</b></p>`
    : html`<${HoldButton} label="MAYDAY: press and hold" name="MAYDAY: press and hold" kind="mayday" onFire=${mayday} />`),
    /** @type {HTMLElement} */ (document.getElementById("foot")));
}

addEventListener("deviceorientationabsolute", (event) => {
  const { alpha } = /** @type {DeviceOrientationEvent} */ (event);
  if (alpha === null) return;
  state.heading = (360 - alpha) % 360;
  if (state.route) show();
});

/** @type {HTMLElement} */ (document.getElementById("page")).textContent = "";
show();
load();
lookForOrders();
request("GET", "/session").then((me) => { state.me = me; }, () => {});
