/** The bar over everything: which mission, how it stands, whether it is live, and STOP for all. */

import { Account } from "./account.js";
import { missionClock, timeOfDay } from "./format.js";
import { EvacuateButton, EvacuationBanner } from "./evacuation.js";
import { HoldButton } from "./hold_button.js";
import { MissionBanner, MissionMenu } from "./mission_state.js";
import { isOpen } from "./node_sensors.js";
import { LookMenu } from "./look_menu.js";
import { ResumeButton } from "./robot_list.js";
import { html } from "./vendor.js";
import { standing } from "./victim_list.js";

/** @import {Store} from "./store.js" */
/** @import {StopControl} from "./stop_control.js" */

/** @type {[("plan" | "both" | "scene"), string, string][]} */
const VIEWS = [["plan", "2D", "Plan only"], ["both", "2D + 3D", "Plan and 3D side by side"], ["scene", "3D", "3D only"]];

const [SHORT, LONG] = [14, 40]; // letters of a mission's name that have room in one line and in two

/** @param {{mission_id: string, name: string} | undefined} mission */
const nameOf = (mission) => mission?.name || mission?.mission_id || "";

/** @type {Record<string, string>} */
const CONNECTIONS = {
  loading: "Connecting", live: "Live", reconnecting: "Reconnecting", stale: "Stale", none: "No mission",
  failed: "Failed",
};

/**
 * @param {{store: Store, stops: StopControl, onMission: (id: string) => void,
 *   onView: (view: "plan" | "both" | "scene") => void}} props
 */
export function TopBar({ store, stops, onMission, onView }) {
  const robots = [...store.robots.values()];
  const live = robots.filter((robot) => store.linkOf(robot).link === "live").length;
  const open = standing(store).filter((victim) => victim.status !== "dismissed").length;
  const alerts = [...store.alerts.values()].filter(isOpen).length;
  const { state } = store.connection;
  const name = store.missions.length === 0 ? "No mission" : nameOf(store.missions.find(({ mission_id }) => mission_id === store.missionId));
  return html`
    <a class="brand" href="/console" aria-label="Waymark, the mission's console">
      <img src="/static/logo.svg" alt="" width="28" height="28"/><span>Waymark</span></a>
    <label class="mission">
      <span class="mission-name" aria-hidden="true" data-size=${name.length > LONG ? 2 : name.length > SHORT ? 1 : 0}>${name}</span>
      <select aria-label="Mission" title=${name} value=${store.missionId ?? ""} disabled=${store.missions.length === 0}
              onChange=${(/** @type {any} */ event) => onMission(event.currentTarget.value)}>
        ${store.missions.length === 0 && html`<option value="">No mission</option>`}
        ${store.missions.map((each) => html`<option value=${each.mission_id}
          selected=${each.mission_id === store.missionId}>${nameOf(each)}</option>`)}
      </select>
    </label>
    <div class="standing"><${MissionMenu} store=${store} />
    <span class=${`connection connection-${state}`} title=${store.connection.reason || "The live stream of the mission"}>
      <i class="dot" aria-hidden="true"></i>${CONNECTIONS[state]}</span></div>
    <dl class="figures-bar">
      <${Figure} label="Mission clock" value=${missionClock(store.mission?.clock_s)} />
      <${Figure} label="Robots live" value=${`${live} / ${robots.length}`} level=${live < robots.length ? "warn" : ""} />
      <${Figure} label="Victims" value=${open} level=${open ? "alarm" : ""} />
      ${alerts > 0 && html`<${Figure} label="Alerts" value=${alerts} level="alarm alerts" />`}
      <${Figure} label="Explored" value=${`${Math.round(store.explored_m2)} m²`} level="explored" />
      <${Figure} label="Tags" value=${store.tags.size} />
    </dl>
    <div class="views" role="group" aria-label="View">
      ${VIEWS.map(([view, label, title]) => html`<button type="button" title=${title} class=${`view-${view}`}
        aria-pressed=${store.view === view} onClick=${() => onView(view)}>${label}</button>`)}
    </div>
    <${LookMenu} store=${store} />
    <${Account} store=${store} />
    <${EvacuateButton} store=${store} />
    <${StopAll} store=${store} stops=${stops} />`;
}

/** @param {{label: string, value: unknown, level?: string}} props */
function Figure({ label, value, level = "" }) {
  return html`<div class=${`bar-figure ${level}`}><dt>${label}</dt><dd>${value}</dd></div>`;
}

/** @param {{store: Store, stops: StopControl}} props */
function StopAll({ store, stops }) {
  const robots = [...store.live.robots.values()];
  const pending = stops.pendingAll;
  if (robots.length > 0 && robots.every((robot) => robot.stopped)) {
    const states = robots.map((robot) => stops.stateOf(robot));
    const standing = states.filter((state) => state === "stopped").length;
    return html`<div class="stop-all-state" role="status">
      <b>${standing === robots.length ? "All stopped" : "Stop ordered"}</b>
      ${standing < robots.length && html`<span>${standing} of ${robots.length} confirmed</span>`}</div>`;
  }
  if (pending?.order === "stop") {
    return html`<div class="stop-all-state unconfirmed" role="status">
      <b>${pending.tries > 1 ? "Not confirmed" : "Stopping all"}</b>
      ${pending.tries > 1 && html`<span>sent ${pending.tries} times</span>`}</div>`;
  }
  return html`<${HoldButton} label="STOP ALL" name="STOP ALL" kind="stop-all" disabled=${robots.length === 0}
    onFire=${() => stops.stop()} />`;
}

/** What stands across the page under the bar. @param {{store: Store, stops: StopControl}} props */
export function Banners({ store, stops }) {
  return html`<${EvacuationBanner} store=${store} /><${MissionBanner} store=${store} /><${StopBanner} store=${store} stops=${stops} />`;
}

/** A strip while every robot is held by an order. @param {{store: Store, stops: StopControl}} props */
function StopBanner({ store, stops }) {
  const robots = [...store.live.robots.values()];
  if (!robots.length || !robots.every((robot) => robot.stopped)) return null;
  return html`<div class="stop-banner">
    <span>All robots are stopped by order. They go on when you resume them.</span>
    <${ResumeButton} stops=${stops} /></div>`;
}

/** @param {{store: Store, onRetry: () => void}} props */
export function Veil({ store, onRetry }) {
  const { state, heardAt, retryAt, reason } = store.connection;
  if (state !== "stale") return null;
  const wait_s = Math.max(0, Math.ceil((retryAt - Date.now()) / 1000));
  return html`<div class="veil-card">
    <strong>STALE since ${timeOfDay(heardAt / 1000)}</strong>
    <span>${reason} ${store.past.at_s === null ? "What you see is the last known state; robots may have moved."
      : "You look at the past; what happens now is not known."}</span>
    <span class="veil-wait">${retryAt ? `Trying again in ${wait_s} s.` : "Trying to connect."}</span>
    <button type="button" onClick=${onRetry}>Try now</button></div>`;
}
