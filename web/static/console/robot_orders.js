/** What a person can tell a robot: go back, stand still, go somewhere, explore by another strategy. */

import { missionPath, request } from "./api.js";
import { fixed, percent } from "./format.js";
import { html } from "./vendor.js";

/** @import {Methods, Order, Robot} from "./types.js" */
/** @import {Store} from "./store.js" */

/** @type {Record<string, string>} */
const ORDERS = {
  return: "Return", hold: "Hold", resume: "Resume exploring", go_to: "Go to", explore_here: "Explore here",
  drop_tag: "Drop a tag",
};
/** @type {Record<string, string>} */
const STATES = { issued: "waiting to be heard", delivered: "under way", done: "done", failed: "failed" };

/** What a robot can be told of its methods: label, and verb of the order. @type {["explore" | "coordinate" | "communication", string, string][]} */
const METHODS = [["explore", "Explores by", "Explore by"], ["coordinate", "Shares out by", "Share out by"],
  ["communication", "Hears others by", "Hear others by"]];
/** The names of all methods; asked for once. @type {Methods | null} */
let methods = null;
let isAsking = false;

/** @param {Store} store */
async function learnMethods(store) {
  if (methods || isAsking) return;
  isAsking = true;
  try {
    methods = await request("GET", "/methods");
  } catch {
    setTimeout(() => store.changed(), 2000); // the next drawing asks again
  }
  isAsking = false;
  store.changed();
}

/**
 * @param {Store} store
 * @param {string} robotId
 * @param {string} what said when it fails
 * @param {Promise<unknown>} answer
 */
async function told(store, robotId, what, answer) {
  try {
    await answer;
  } catch (error) {
    const { status, message } = /** @type {import("./api.js").ApiError} */ (error);
    // Without an answer nobody knows: the order may have come through, and is in the list then.
    store.notify(`${what} ${status ? "was not" : "may not have been"} ordered for ${robotId}. ${message}`);
  }
  store.changed();
}

/**
 * @param {Store} store
 * @param {string} robotId
 * @param {string} kind
 * @param {{x_m: number, y_m: number}} [place]
 */
export function order(store, robotId, kind, place) {
  const path = `${missionPath(store.missionId ?? "")}/robots/${encodeURIComponent(robotId)}/orders`;
  return told(store, robotId, ORDERS[kind] ?? kind, request("POST", path, { kind, ...place }));
}

/**
 * @param {Store} store
 * @param {string} robotId
 * @param {Record<string, string>} changed
 */
function change(store, robotId, changed) {
  const path = `${missionPath(store.missionId ?? "")}/robots/${encodeURIComponent(robotId)}`;
  return told(store, robotId, "The change", request("PATCH", path, changed));
}

/**
 * Hand a place on the plan to whatever waits for one; say whether anything did.
 * @param {Store} store
 * @param {{x_m: number, y_m: number}} place
 */
export function pickPlace(store, place) {
  if (!store.picking) return false;
  const { then } = store.picking;
  store.picking = null;
  then({ x_m: Number(place.x_m.toFixed(2)), y_m: Number(place.y_m.toFixed(2)) });
  return true;
}

/** How much of what the team has explored is in this robot's own map, 0..1. @param {Robot} robot @param {Store} store */
export function shareOf(robot, store) {
  return store.explored_m2 > 0 ? Math.min(1, robot.explored_m2 / store.explored_m2) : 0;
}

/** Whether the latest order keeps the robot from exploring. @param {Order | undefined} latest */
const holds = (latest) => latest !== undefined && ["return", "hold", "go_to"].includes(latest.kind) && latest.state !== "failed";

/** The keys T, H, O, P and D: an order to the selected robot. @param {Store} store @param {string} key */
export function orderByKey(store, key) {
  const id = store.selected?.kind === "robot" ? store.selected.id : null;
  if (!id) return;
  if (key === "o" || key === "p") pick(store, id, key === "o" ? "go_to" : "explore_here");
  else if (key === "h") order(store, id, holds(store.orders.get(id)?.orders[0]) ? "resume" : "hold");
  else order(store, id, key === "t" ? "return" : "drop_tag");
}

/** On the selected robot's card. @param {{robot: Robot, store: Store}} props */
export function RobotOrders({ robot, store }) {
  learnMethods(store);
  const id = robot.robot_id;
  const latest = store.orders.get(id)?.orders[0];
  /** @param {string} kind @param {string} label */
  const button = (kind, label) => html`<button type="button" onClick=${() => order(store, id, kind)}>${label}</button>`;
  /** @param {"go_to" | "explore_here"} kind @param {string} label */
  const picker = (kind, label) => html`<button type="button"
    aria-pressed=${store.picking?.id === id && store.picking.kind === kind}
    onClick=${() => pick(store, id, kind)}>${label}</button>`;
  return html`
    <fieldset class="robot-orders" disabled=${store.isOver}>
      <div class="order-buttons" role="group" aria-label=${`Orders to ${id}`}>
        ${button("return", "Return")}${holds(latest) ? button("resume", "Resume") : button("hold", "Hold")}
        ${picker("go_to", "Go to…")}${picker("explore_here", "Explore here…")}${button("drop_tag", "Drop tag")}
      </div>
      ${store.picking?.id === id && html`<p class="order-state" role="status">
        Click on the plan: that is where ${id} goes.</p>`}
      <p class="order-state">Its own map holds ${fixed(robot.explored_m2, 0)} m², ${
        percent(shareOf(robot, store))} of what the team has explored.</p>
      ${methods && html`<${Ways} robot=${robot} store=${store} known=${methods} />`}
      ${latest && html`<${Latest} order=${latest} />`}
    </fieldset>`;
}

/** How it explores and agrees with the others. @param {{robot: Robot, store: Store, known: Methods}} props */
function Ways({ robot, store, known }) {
  const { coordinate = "none", communication = "tags" } = robot.methods ?? {};
  const isDeaf = !["full", "radio"].includes(communication) && !["none", "node-counting"].includes(coordinate);
  return html`${METHODS.map(([key, label]) => {
    const now = robot.methods?.[key] ?? "";
    return html`<label class="strategy"><span>${label}</span>
      <select value=${now} onChange=${(/** @type {any} */ event) =>
        change(store, robot.robot_id, { [key]: event.currentTarget.value })}>
        ${known[key].map((name) => html`<option value=${name} selected=${name === now}>${name}</option>`)}
      </select></label>`;
  })}${isDeaf && html`<p class="order-state">It hears nobody by ${communication}, so it shares out nothing: let it hear by full or radio.</p>`}`;
}

/** @param {Order} order */
function nameOf(order) {
  if (order.kind !== "methods") return ORDERS[order.kind] ?? order.kind;
  const told = METHODS.filter(([key]) => order[key]).map(([key, , verb]) => `${verb} ${order[key]}`);
  return told.length ? told.join(", ") : "Explore as before";
}

/** On a card that is not open: an order that waits or is under way. @param {{store: Store, robotId: string}} props */
export function Pending({ store, robotId }) {
  const latest = store.orders.get(robotId)?.orders[0];
  if (!latest || !["issued", "delivered"].includes(latest.state)) return null;
  return html`<span class="pending">${nameOf(latest)}: ${STATES[latest.state]}</span>`;
}

/** @param {{order: Order}} props */
function Latest({ order }) {
  const what = nameOf(order);
  return html`<p class=${`order-state order-${order.state}`} role="status"><b>${what}: ${STATES[order.state]}</b>${
    order.text && html`, ${order.text}`}.</p>`;
}

/**
 * @param {Store} store
 * @param {string} robotId
 * @param {"go_to" | "explore_here"} kind
 */
function pick(store, robotId, kind) {
  const isAgain = store.picking?.id === robotId && store.picking.kind === kind;
  store.picking = isAgain ? null : { id: robotId, kind, then: (place) => order(store, robotId, kind, place) };
  store.changed();
}
