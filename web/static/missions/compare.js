/** Missions side by side: what each came to, and how fast. */

import { missionClock } from "../console/format.js";
import { STATES } from "../console/mission_state.js";
import { html } from "../console/vendor.js";

/** @import {Sample, Summary} from "./types.js" */

const WIDTH = 860, HEIGHT = 300, LEFT = 64, RIGHT = 150, TOP = 16, BOTTOM = 40;
const FEWEST_S = 60;

/** @param {number} k */
const colorOf = (k) => `var(--robot-${(k % 12) + 1})`;

/** Seconds of the robots' own clock since the first sample. @param {Sample[]} samples */
const times = (samples) => samples.map(({ clock_s }) => Math.max(0, clock_s - samples[0].clock_s));

/** @param {Summary} summary */
const driven_m = ({ robots }) => robots.reduce((sum, robot) => sum + robot.distance_m, 0);

/** @param {Record<string, number>} counts */
const counted = (counts) => Object.entries(counts).map(([name, count]) => `${count} ${name.replaceAll("_", " ")}`).join(", ") || "none";

/** When half of what was explored in the end was explored. @param {Sample[]} samples */
function halfAt(samples) {
  const k = samples.findIndex(({ explored_m2 }) => explored_m2 >= 0.5 * samples[samples.length - 1].explored_m2);
  return k < 0 ? "–" : missionClock(times(samples)[k]);
}

/** @type {[string, (summary: Summary) => string | number][]} */
const ROWS = [
  ["State", ({ mission }) => STATES[mission.state][0]],
  ["Ran for", ({ mission }) => missionClock(mission.duration_s)],
  ["Explored", ({ mission }) => `${Math.round(mission.explored_m2)} m²`],
  ["Half of that after", ({ progress }) => progress.length ? halfAt(progress) : "–"],
  ["Robots", ({ robots }) => robots.length],
  ["Driven by all", (summary) => `${Math.round(driven_m(summary))} m`],
  ["Explored a robot", ({ mission, robots }) => robots.length ? `${Math.round(mission.explored_m2 / robots.length)} m²` : "–"],
  ["Victims", ({ victims }) => counted(victims)],
  ["Tags", ({ mission }) => mission.tags],
  ["Warnings and alarms", ({ alerts }) => counted(alerts)],
];

/** @param {{summaries: Summary[], onClose: () => void}} props */
export function Comparison({ summaries, onClose }) {
  return html`<section id="comparison" tabindex="-1" aria-labelledby="comparison-title">
    <div class="row"><h2 class="grow" id="comparison-title">${summaries.map(({ mission }) => mission.name).join(" and ")}</h2>
      <button type="button" onClick=${onClose}>Close the comparison</button></div>
    <div class="table" tabindex="0" role="region" aria-label="Figures side by side"><table>
      <thead><tr><th></th>${summaries.map(({ mission }, k) => html`<th scope="col"><i class="swatch" style=${{ background: colorOf(k) }}></i>
        ${mission.name}</th>`)}</tr></thead>
      <tbody>${ROWS.map(([label, value]) => html`<tr><th scope="row">${label}</th>${
        summaries.map((summary) => html`<td>${value(summary)}</td>`)}</tr>`)}</tbody></table></div>
    <${Chart} summaries=${summaries} /></section>`;
}

/** Ground explored over time. @param {{summaries: Summary[]}} props */
function Chart({ summaries }) {
  const drawn = summaries.filter(({ progress }) => progress.length > 0);
  if (drawn.length === 0) return html`<p class="none">None of these missions has explored anything yet, so there is no curve.</p>`;
  const end_s = Math.max(FEWEST_S, ...drawn.flatMap(({ progress }) => times(progress)));
  const top_m2 = nice(Math.max(1, ...drawn.flatMap(({ progress }) => progress.map(({ explored_m2 }) => explored_m2))));
  /** @param {number} s */
  const x = (s) => LEFT + (s / end_s) * (WIDTH - LEFT - RIGHT);
  /** @param {number} m2 */
  const y = (m2) => HEIGHT - BOTTOM - (m2 / top_m2) * (HEIGHT - TOP - BOTTOM);
  const words = drawn.map(({ mission, progress }) => `${mission.name}: ${Math.round(progress[progress.length - 1].explored_m2)} square metres after ${
    missionClock(times(progress)[progress.length - 1])}`).join("; ");
  return html`<figure><figcaption>Ground explored over the robots' own time, square metres</figcaption>
    <svg class="chart" viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${words}>
      ${[0, 0.25, 0.5, 0.75, 1].map((share) => html`
        <line class="axis" x1=${LEFT} x2=${WIDTH - RIGHT} y1=${y(share * top_m2)} y2=${y(share * top_m2)}/>
        <text x=${LEFT - 8} y=${y(share * top_m2) + 4} text-anchor="end">${Number((share * top_m2).toPrecision(3))}</text>
        <text x=${x(share * end_s)} y=${HEIGHT - BOTTOM + 22} text-anchor="middle">${missionClock(share * end_s)}</text>`)}
      ${labelled(drawn, y).map(({ summary, at, k }) => html`
        <path d=${line(summary.progress, x, y)} stroke=${colorOf(summaries.indexOf(summary))}/>
        <text class="name" key=${k} x=${WIDTH - RIGHT + 8} y=${at + 4}>${summary.mission.name.slice(0, 18)}</text>`)}
    </svg></figure>`;
}

/** A name beside the end of each curve, none over another. @param {Summary[]} drawn @param {(m2: number) => number} y */
function labelled(drawn, y) {
  const last = drawn.map((summary, k) => ({ summary, k, at: y(summary.progress[summary.progress.length - 1].explored_m2) }));
  last.sort((a, b) => b.at - a.at);
  for (let k = 1; k < last.length; k++) last[k].at = Math.min(last[k].at, last[k - 1].at - 16);
  return last;
}

/** @param {Sample[]} samples @param {(s: number) => number} x @param {(m2: number) => number} y */
function line(samples, x, y) {
  const at = times(samples);
  return samples.map(({ explored_m2 }, k) => `${k ? "L" : "M"}${x(at[k]).toFixed(1)} ${y(explored_m2).toFixed(1)}`).join("");
}

/** The next 1, 2 or 5 times a power of ten. @param {number} value */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 5].find((factor) => factor * power >= value) ?? 10) * power;
}
