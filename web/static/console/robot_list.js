/** The robots' cards: what each is doing and why, how well it is, and its STOP. */

import { robotStyle } from "./color.js";
import { age, ellipse, fixed, metres, percent } from "./format.js";
import { HoldButton } from "./hold_button.js";
import { Pending, RobotOrders, shareOf } from "./robot_orders.js";
import { html } from "./vendor.js";

/** @import {Robot} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @import {StopControl} from "./stop_control.js" */

const ROOMY = 5; // more robots than this get shorter cards,
const MANY = 8; // more than this two lines each: twelve on a laptop's screen

/** @type {Record<string, string>} */
const ACTIVITIES = {
  starting: "Starting", exploring: "Exploring", returning: "Returning", holding: "Holding", stuck: "Stuck", done: "Finished",
};
/** @type {Record<string, string>} */
const LINKS = { live: "Live", late: "Late", lost: "Lost" };

/** @type {Record<string, string>} */
const STOP_WORDS = {
  sending: "Stopping", unconfirmed: "No answer", ordered: "Stop ordered", silent: "Not heard", heard: "STOP heard",
  braking: "Braking", stopped: "Stopped",
};

/** @param {{store: Store, stops: StopControl, onSelect: (id: string) => void}} props */
export function RobotList({ store, stops, onSelect }) {
  const robots = store.robotList();
  const group = [...store.group].sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
  return html`
    <h2 class="panel-title">Robots <span class="count">${robots.length || ""}</span>
      ${group.length === 0 ? robots.length > MANY && html`<span class="group-head" aria-hidden="true">Group</span>` : html`<${HoldButton} label=${`STOP ${group.join(", ")}`} name=${`Stop the group: ${group.join(", ")}`}
        kind="stop" onFire=${() => group.forEach((id) => stops.stop(id))} />`}</h2>
    ${robots.length === 0 && html`<p class="hint">
      ${store.mission ? "No robot has been heard in this mission yet." : "No mission is open."}</p>`}
    <ul class=${`cards ${robots.length > ROOMY ? "compact" : ""} ${robots.length > MANY ? "dense" : ""}`}>
      ${robots.map((robot) => html`<${RobotCard} key=${robot.robot_id} robot=${robot} store=${store} stops=${stops}
        isCompact=${robots.length > ROOMY} onSelect=${onSelect} />`)}
    </ul>`;
}

/**
 * @param {{robot: Robot, store: Store, stops: StopControl, isCompact: boolean,
 *   onSelect: (id: string) => void}} props
 */
function RobotCard({ robot, store, stops, isCompact, onSelect }) {
  const id = robot.robot_id;
  const { link, age_s } = store.linkOf(robot);
  const isSelected = store.isSelectedRobot(id);
  const now = store.live.robots.get(id) ?? robot; // STOP is for now, whatever is looked at
  const stop = stops.stateOf(now);
  const battery = robot.battery;
  const isLow = battery !== null && battery < 0.2;
  const reason = (store.past.board ? "" : stops.wordsOf(now)) || robot.reason || "No reason given.";
  const state = html`<${State} robot=${robot} isLost=${link === "lost"} isCompact=${isCompact} />`;
  return html`
    <li class=${`card robot-card ${isSelected ? "selected" : ""}`} data-robot=${id} data-link=${link}
        data-stop=${stop} style=${{ "--robot": robotStyle(id) }}>
      <button class="card-body" type="button" aria-pressed=${isSelected} onClick=${() => onSelect(id)}
              title=${`Show ${id} in the middle of the plan`}>
        <span class="card-head">
          <svg class="swatch" viewBox="0 0 32 32" aria-hidden="true">
            <path d="M16 2.5 27 27.5Q27.4 28.9 26 28.3L16 23.6 6 28.3Q4.6 28.9 5 27.5Z" /></svg>
          <span class="card-name">${id}</span>
          ${isCompact && state}
          <span class=${`link link-${link}`}>
            <i class="dot" aria-hidden="true"></i><span class="link-word">${LINKS[link] ?? link}</span>
            <span class="age">${isCompact ? age(age_s).replace(" ago", "") : age(age_s)}</span>
          </span>
        </span>
        ${!isCompact && state}
        <span class="reason" title=${reason}>${reason}</span>
        ${!isSelected && html`<${Pending} store=${store} robotId=${id} />`}
        <span class="figures">
          <${Figure} label="Battery" value=${percent(battery)} warn=${isLow}>
            ${battery !== null && html`<span class="gauge" aria-hidden="true">
              <i style=${{ width: `${Math.round(100 * Math.min(1, Math.max(0, battery)))}%` }}></i></span>`}
          <//>
          <${Figure} label="Tags" value=${fixed(robot.tags_left, 0)} warn=${robot.tags_left === 0} />
          <${Figure} label="Driven" value=${metres(robot.distance_m)} />
          <${Figure} label="Explored" value=${`${fixed(robot.explored_m2, 0)} m²`}>
            <span class="gauge share" title=${`${percent(shareOf(robot, store))} of what the team has explored`}>
              <i style=${{ width: `${Math.round(100 * shareOf(robot, store))}%` }}></i></span>
          <//>
          <${Figure} label="Position" value=${`± ${fixed(ellipse(robot.covariance).major_m, 2)} m`} />
        </span>
      </button>
      <div class="card-stop">
        ${stop === "free"
          ? html`<${HoldButton} label="STOP" name=${`Stop ${id}`} kind="stop" onFire=${() => stops.stop(id)} />`
          : html`<div class=${`stop-state stop-${stop}`} role="status">${STOP_WORDS[stop]}</div>`}
        <label class="in-group" title="Robots of the group are stopped together, at the top of this list">
          <input type="checkbox" aria-label=${`${id} is in the group`} checked=${store.group.has(id)} onChange=${() => {
            if (!store.group.delete(id)) store.group.add(id);
            store.changed();
          }}/><span>Group</span></label>
      </div>
      ${isSelected && html`<${RobotOrders} robot=${robot} store=${store} />`}
      ${robot.stopped && !store.past.board && html`
        <div class="card-foot">
          <${ResumeButton} stops=${stops} robotId=${id} />
        </div>`}
    </li>`;
}

/** Kinds of SLAM other than the usual one: short name and what it is. @type {Record<string, [string, string]>} */
const SLAM_KINDS = {
  ekf: ["EKF", "Kalman filter over tags heard by radio"],
  rslam: ["RSLAM", "Particles over ranges to nodes"],
  odometry: ["Odometry", "Dead reckoning and scan matching alone"],
};

/** The robot's state in words; a short card has room for the one that matters most. */
/** @param {{robot: Robot, isLost: boolean, isCompact: boolean}} props */
function State({ robot, isLost, isCompact }) {
  const activity = ACTIVITIES[robot.activity] ?? robot.activity;
  const trouble = robot.agent_down ? html`<span class="badge warn" title="What it sends is kept until its agent is back">Agent down</span>`
    : robot.slipping && html`<span class="badge warn">Slipping</span>`;
  return html`<span class="state">
    ${isCompact && trouble ? null : html`<b class=${robot.activity === "stuck" ? "warn" : ""}>
      ${isLost && !isCompact ? `Last known: ${activity.toLowerCase()}` : activity}</b>`}
    ${trouble}
    ${!isCompact && !robot.located && html`<span class="badge" title="Not yet joined to the team's map">
      Not located</span>`}
    ${!isCompact && SLAM_KINDS[robot.slam ?? ""] && html`<span class="badge" title=${SLAM_KINDS[robot.slam ?? ""][1]}>
      ${SLAM_KINDS[robot.slam ?? ""][0]}</span>`}
    ${!isCompact && robot.agent === "onboard" && html`<span class="badge" title="Decides on board">On board</span>`}
  </span>`;
}

/** @param {{label: string, value: string, warn?: boolean, children?: unknown}} props */
function Figure({ label, value, warn, children }) {
  return html`<span class="figure">
    <span class="figure-label">${label}</span>
    <span class=${`figure-value ${warn ? "warn" : ""}`}>${value}</span>${children}</span>`;
}

/** @param {{stops: StopControl, robotId?: string}} props */
export function ResumeButton({ stops, robotId }) {
  const isAsked = stops.isAsked(robotId);
  const isPending = stops.pending.get(robotId ?? "*")?.order === "resume";
  const who = robotId ?? "all";
  return html`<button type="button" class=${`quiet resume ${isAsked ? "asked" : ""}`} disabled=${isPending}
      onClick=${() => stops.resume(robotId)}
      aria-label=${isAsked ? `Confirm: resume ${who}` : `Resume ${who}, asks once more`}>
    ${isPending ? "Resuming" : isAsked ? `Press again to resume ${who}` : robotId ? "Resume" : "Resume all"}</button>`;
}
