/** The time bar: the whole mission from its beginning to now, to scrub, to play, and to jump to what happened. */

import { missionPath } from "./api.js";
import { age, timeOfDay } from "./format.js";
import { SPEEDS } from "./past.js";
import { SHAPES } from "./time_marks.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */
/** @import {TimeMarks} from "./time_marks.js" */

const STEP_S = 1;
const LONG_STEP_S = 10;
const FILM_TAKES = "Making it takes up to half a minute for twelve robots, and longer while the server is busy.";
const ICONS = {
  play: "M4 2 14 8 4 14Z", pause: "M3 2h3.5v12H3ZM9.5 2H13v12H9.5Z", back: "M10 2 4 8l6 6Z", on: "M6 2l6 6-6 6Z",
  before: "M3 2h2v12H3ZM14 2 6 8l8 6Z", after: "M11 2h2v12h-2ZM2 2l8 6-8 6Z",
};

/** @param {{store: Store, marks: TimeMarks}} props */
export function TimeBar({ store, marks }) {
  const { past } = store;
  if (!store.live.mission || !past.spans.length) return null;
  const { axis, at_s } = past;
  const place = at_s === null ? axis.length_s : axis.at(at_s);
  const words = at_s === null ? "Now, live" : `${timeOfDay(at_s)}, ${age(store.serverNow() - at_s)}`;
  return html`
    <div class="time-buttons" role="group" aria-label="Playing">
      <${Icon} icon="before" label="To the event before ([)" isWide=${true} onClick=${() => jump(store, marks, -1)} />
      <${Icon} icon="back" label="A second back (,)" isWide=${true} onClick=${() => past.step(-STEP_S)} />
      <${Icon} icon=${past.isPlaying ? "pause" : "play"} label=${past.isPlaying ? "Pause (Y)" : "Play (Y)"}
        onClick=${() => toggle(store)} />
      <${Icon} icon="on" label="A second on (.)" isWide=${true} onClick=${() => past.step(STEP_S)} />
      <${Icon} icon="after" label="To the next event (])" isWide=${true} onClick=${() => jump(store, marks, 1)} />
      <label class="time-speed"><span class="unseen">Speed</span>
        <select value=${past.speed} onChange=${(/** @type {any} */ event) => (past.speed = Number(event.currentTarget.value))}>
          ${SPEEDS.map((speed) => html`<option value=${speed} selected=${speed === past.speed}>${speed}×</option>`)}
        </select></label>
    </div>
    <div class="time-track">
      <div class="time-marks" aria-hidden="true">${marks.marks().map(({ event, shape, share, count }) => html`
        <svg key=${event.event_id} viewBox="-1 -1 14 14" class=${`time-mark ${shape}`} style=${{ left: `${100 * share}%` }}
            onClick=${() => past.seek(event.unix_s)}>
          <title>${timeOfDay(event.unix_s)} ${event.text}${count > 1 ? ` And ${count - 1} more.` : ""}</title>
          <path d=${SHAPES[shape].path} /></svg>`)}</div>
      <input type="range" min="0" max=${axis.length_s} step="0.1" value=${place} aria-label="Moment of the mission"
        aria-valuetext=${words}
        onInput=${(/** @type {any} */ event) => past.seek(axis.moment(Number(event.currentTarget.value)))}
        onKeyDown=${(/** @type {KeyboardEvent} */ event) => sliderKey(store, marks, event)} />
    </div>
    <output class="time-words"><b>${timeOfDay(at_s ?? store.serverNow())}</b>
      <span>${at_s === null ? "now" : age(store.serverNow() - at_s)}</span></output>
    <button type="button" class="time-live" aria-pressed=${at_s === null} title="Back to what is now (L)"
      onClick=${() => past.live()}>${at_s === null ? "Live" : html`<span>Back to </span>live`}</button>
    <a class="time-wide" href=${`/api/v1${missionPath(past.missionId)}/report.html`} target="_blank" rel="noopener"
      title="Everything so far in one file, to hand over or print">Report</a>
    <a class="time-wide" href=${`/viser/${encodeURIComponent(past.missionId)}/?hideViserLogo&darkMode&playbackPath=/api/v1${missionPath(past.missionId)}/history/recording.viser`}
      target="_blank" rel="noopener" title=${`The mission so far in 3D, to play and to keep. ${FILM_TAKES}`}
      onClick=${() => store.notify(`The 3D film opens in another tab. ${FILM_TAKES}`)}>3D film</a>`;
}

/** @param {{icon: keyof typeof ICONS, label: string, isWide?: boolean, onClick: () => void}} props */
function Icon({ icon, label, isWide, onClick }) {
  return html`<button type="button" class=${isWide ? "time-wide" : ""} aria-label=${label} title=${label} onClick=${onClick}>
    <svg viewBox="0 0 16 16" aria-hidden="true"><path d=${ICONS[icon]} /></svg></button>`;
}

/** Across the page while somebody looks at the past. @param {{store: Store}} props */
export function PastBanner({ store }) {
  const { past, live } = store;
  if (past.at_s === null) return null;
  const since = [...live.alerts.values()].filter((alert) =>
    alert.acknowledged_unix_s == null && alert.raised_unix_s > past.left_s).length;
  return html`<div class="past-banner" role="status">
    <span><strong>You look at ${timeOfDay(past.at_s)}, ${age(store.serverNow() - past.at_s)}</strong>; orders are off. STOP works.
      ${past.trouble && html` <b>${past.trouble}</b>`}</span>
    ${since > 0 && html`<b class="past-alert">${since === 1 ? "A new alert" : `${since} new alerts`} now</b>`}
    <button type="button" onClick=${() => past.live()}>Back to live</button></div>`;
}

/** @param {Store} store */
function toggle({ past }) {
  past.isPlaying ? past.pause() : past.play();
}

/** @param {Store} store @param {TimeMarks} marks @param {1 | -1} way */
function jump({ past }, marks, way) {
  const event = marks.neighbour(past.at_s ?? past.axis.ends_s + 1, way);
  past.pause();
  if (event) past.seek(event.unix_s);
}

/** Steps of a second, not of the tenth by which the slider is dragged. @param {Store} store @param {TimeMarks} marks @param {KeyboardEvent} event */
function sliderKey(store, marks, event) {
  const steps = { ArrowLeft: -STEP_S, ArrowDown: -STEP_S, ArrowRight: STEP_S, ArrowUp: STEP_S };
  const step = steps[/** @type {keyof typeof steps} */ (event.key)];
  if (step) store.past.step(event.shiftKey ? LONG_STEP_S * step : step);
  else if (event.key === "PageUp" || event.key === "PageDown") jump(store, marks, event.key === "PageUp" ? 1 : -1);
  else return;
  event.preventDefault();
}

/** @param {Store} store @param {TimeMarks} marks @returns {import("./keys.js").ShortCut[]} */
export const timeKeys = (store, marks) => [
  { keys: ", .", words: "The past: a second back, a second on",
    act: (key) => store.past.step(key === "," ? -STEP_S : STEP_S) },
  { keys: "< >", words: "The past: ten seconds back, ten seconds on",
    act: (key) => store.past.step(key === "<" ? -LONG_STEP_S : LONG_STEP_S) },
  { keys: "[ ]", words: "The past: to the event before, to the next", act: (key) => jump(store, marks, key === "[" ? -1 : 1) },
  { keys: "y l", words: "The past: play or pause, back to live", act: (key) => (key === "l" ? store.past.live() : toggle(store)) },
];
