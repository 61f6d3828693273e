/** The way there: one arrow, one number, the next tag; spoken on request. */

import { html } from "../console/vendor.js";
import { language } from "./language.js";
import { state } from "./state.js";
import { say } from "./texts.js";
import { lead, target, touch } from "./touch.js";
import { bearing, metres } from "./words.js";

/** @import {Route, Step} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

const STRAIGHT_DEG = 35;
const BACK_DEG = 145;

/** Where to turn with the tag one came from behind one: what is left to say without a compass. @param {Step} step */
function turnFrom(step) {
  const { roads, before } = state;
  if (!roads || !before) return null;
  const edge = roads.neighbours(before).find(({ to }) => roads.tags[to].tag_id === step.from_tag);
  if (!edge || edge.way[6]) return null; // where somebody walked is not known
  const [x0, y0, x1, y1] = edge.points.slice(-4);
  const came = (-Math.atan2(y1 - y0, x1 - x0) * 180) / Math.PI;
  const [start, next] = step.points_m;
  const turn = ((((bearing(next[0] - start[0], next[1] - start[1]) - came + 180) % 360) + 360) % 360) - 180;
  const key = Math.abs(turn) <= STRAIGHT_DEG ? "keep_behind" : Math.abs(turn) > BACK_DEG ? "go_back" : turn < 0 ? "behind_left" : "behind_right";
  return { turn, text: say(/** @type {Key} */ (key), { tag: before, far: metres(step.distance_m) }) };
}

/** @param {string} text */
function speak(text) {
  const said = new SpeechSynthesisUtterance(text);
  said.lang = language();
  speechSynthesis.cancel();
  speechSynthesis.speak(said);
}

/** @param {{route: Route, to: string}} props */
export function Guide({ route, to }) {
  const step = route.legs[0] ?? route.last;
  const [kind] = to.split(":");
  const goal = kind === "note" ? say("goal_note", { name: "" }).trim() : route.goal;
  if (!step) return html`<section class="go"><p class="next">${say("there", { goal })}</p>
    <button type="button" onClick=${() => lead(null)}>${say("done")}</button></section>`;
  const here = metres(step.distance_m);
  const next = step.to_tag ? say("to_tag", { tag: step.to_tag }) : say(/** @type {Key} */ (`to_the_${kind}`));
  const heading = state.roads?.north === null ? null : state.heading; // a compass is no help on a plan that nobody has turned to north
  const relative = heading === null ? turnFrom(step) : null;
  const whole = Math.max(target()?.whole_m ?? 0, route.distance_m);
  return html`<section class="go" aria-label=${say("way_to", { goal })}>
    <p class="soft">${say("to_goal", { goal, far: metres(route.distance_m) })}</p>
    <${Arrow} step=${step} turn=${relative ? relative.turn : step.bearing_deg - (heading ?? state.roads?.north ?? 0)} />
    <p class="number">${step.uncertain ? say("about", { far: here }) : here}</p>
    <p class="next">${next}</p>
    ${relative && html`<p class="text"><b>${relative.text}</b></p>`}
    <p class="text">${step.text}</p>
    ${step.uncertain && html`<p class="trouble">${say("leg_unsure")}</p>`}
    <progress max=${whole} value=${whole - route.distance_m} aria-label=${say("progress")}></progress>
    <p class="soft">${say(relative ? "arrow_from_behind" : heading === null ? "north_up" : "magnetic")}</p>
    ${state.roads?.north === null && html`<p class="soft">${say("plan_north")}</p>`}
    <div class="row">${step.to_tag && html`<a class="button" href=${`/t/${encodeURIComponent(step.to_tag)}`}
        onClick=${(/** @type {Event} */ event) => { event.preventDefault(); touch(/** @type {string} */ (step.to_tag), state.where?.mission_id); }}>
        ${say("i_am_at", { tag: step.to_tag })}</a>`}
      ${"speechSynthesis" in window && html`<button type="button" onClick=${() => speak(`${relative?.text ?? ""} ${step.text}`)}>${say("say_it")}</button>`}
      <button type="button" onClick=${() => lead(null)}>${say("stop_leading")}</button></div></section>`;
}

/** @param {{step: Step, turn: number}} props */
function Arrow({ step, turn }) {
  return html`<svg viewBox="0 0 100 100" role="img" aria-label=${say(state.roads?.north === null ? "arrow_on_plan" : "arrow", { degrees: Math.round(step.bearing_deg) })}>
    <g transform=${`rotate(${turn} 50 50)`}><path d="M50 6 86 80 50 64 14 80Z" fill="var(--accent)" /></g></svg>`;
}
