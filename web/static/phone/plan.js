/** The plan round the phone: what is known of the building, tags, ways, the route, and where the phone may be. */

import { Component, html } from "../console/vendor.js";
import { placeNow } from "./between.js";
import { headingOnPlan } from "./compass.js";
import { drawFix, reachOfFix } from "./fix_draw.js";
import { state } from "./state.js";
import { say } from "./texts.js";
import { inMetres } from "./words.js";

/** @import {Pocket, Plan} from "./types.js" */

const HALF_M = 8; // shown to each side of the phone
const MOST_M = 25;

/** @type {{version: string, image: ImageBitmap | null} | null} */
let drawn = null;

/** The picture of a plan, decoded once. @param {string} mission @param {Plan} plan @param {() => void} then */
function pictureOf(mission, plan, then) {
  const version = `${mission} ${plan.version}`;
  if (drawn?.version === version) return drawn.image;
  const before = drawn?.image ?? null;
  drawn = { version, image: before };
  const bytes = Uint8Array.from(atob(plan.png), (letter) => letter.charCodeAt(0));
  createImageBitmap(new Blob([bytes], { type: "image/png" })).then((image) => {
    if (drawn?.version !== version) return;
    drawn.image = image;
    then();
  }, () => undefined);
  return before;
}

export class PlanView extends Component {
  componentDidMount() { this.draw(); }
  componentDidUpdate() { this.draw(); }

  draw() {
    const canvas = /** @type {HTMLCanvasElement | null} */ (/** @type {any} */ (this).base);
    const context = canvas?.getContext?.("2d");
    const tag = state.roads?.tags[state.roads.numbers.get(state.tagId) ?? -1];
    const me = placeNow() ?? tag ?? middleOfFix();
    if (!canvas || !context || !state.pocket || !me) return;
    const side = Math.round(canvas.clientWidth * devicePixelRatio);
    if (!side) return;
    canvas.width = canvas.height = side;
    const scale = side / (2 * Math.min(Math.max(HALF_M, reachOfFix(me)), MOST_M));
    /** North (x) is up, west (y) is left. @param {number} x_m @param {number} y_m */
    const at = (x_m, y_m) => /** @type {const} */ ([side / 2 - (y_m - me.y_m) * scale, side / 2 - (x_m - me.x_m) * scale]);
    drawPlan(context, state.pocket, at, scale, () => this.draw());
    drawWays(context, at, scale);
    drawPoints(context, state.pocket, at, scale);
    drawFix(context, at, scale);
    const own = placeNow() ?? tag;
    if (own) drawMe(context, own, at, scale);
  }

  render() {
    return html`<canvas class="plan" role="img" aria-label=${state.tagId ? say("plan_label", { tag: state.tagId }) : say("plan_of_fix")}></canvas>`;
  }
}

/** The middle of the plan where no tag was read yet. @returns {{x_m: number, y_m: number} | null} */
function middleOfFix() {
  const id = state.fix?.ring?.node_id;
  return (id && state.roads?.tags[state.roads.numbers.get(id) ?? -1]) || state.fix?.places[0] || null;
}

/** @typedef {(x_m: number, y_m: number) => readonly [number, number]} At */

/** @param {CanvasRenderingContext2D} context @param {Pocket} pocket @param {At} at @param {number} scale @param {() => void} again */
function drawPlan(context, pocket, at, scale, again) {
  const plan = pocket.map;
  const image = plan && pictureOf(pocket.mission_id, plan, again);
  if (!plan || !image) return;
  const cell = plan.resolution_m * scale;
  const [left, top] = at(plan.origin_m[0], plan.origin_m[1]);
  context.save();
  context.imageSmoothingEnabled = false;
  // the picture's right is x (north) and its top the largest y (west): turned by a quarter it has north up
  context.transform(0, -cell, cell, 0, left - plan.height * cell, top);
  context.drawImage(image, 0, 0);
  context.restore();
}

/** @param {CanvasRenderingContext2D} context @param {At} at @param {number} scale */
function drawWays(context, at, scale) {
  const { roads, route } = state;
  for (const edges of roads?.next ?? []) for (const edge of edges) line(context, inMetres(edge.points), at, "#5ccfff55", 0.1 * scale);
  for (const leg of [...(route?.legs ?? []), ...(route?.last ? [route.last] : [])]) line(context, leg.points_m, at, "#5ccfff", 0.25 * scale);
}

/** @param {CanvasRenderingContext2D} context @param {[number, number][]} points @param {At} at @param {string} color @param {number} width */
function line(context, points, at, color, width) {
  context.beginPath();
  points.forEach(([x, y], k) => context[k ? "lineTo" : "moveTo"](...at(x, y)));
  context.strokeStyle = color;
  context.lineWidth = width;
  context.lineJoin = context.lineCap = "round";
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context @param {Pocket} pocket @param {At} at @param {number} scale */
function drawPoints(context, pocket, at, scale) {
  context.font = `${Math.max(12, 0.9 * scale)}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  /** @type {Box[]} */
  const names = [];
  for (const { victim_id, x_m, y_m, status } of pocket.victims) {
    if (status !== "dismissed") point(context, at(x_m, y_m), victim_id, "#ff5a5f", scale, names);
  }
  for (const { kind, text, x_m, y_m } of state.roads?.notes ?? pocket.notes) {
    if (x_m !== null && y_m !== null && kind === "hazard") point(context, at(x_m, y_m), `! ${text.slice(0, 20)}`, "#ffbe4d", scale, names);
  }
  const tags = [...pocket.tags].sort((a, b) => Number(b.tag_id === state.tagId) - Number(a.tag_id === state.tagId));
  for (const { tag_id, x_m, y_m } of tags) point(context, at(x_m, y_m), tag_id, "#ffc857", scale, names);
}

/** Left, top, right, bottom. @typedef {[number, number, number, number]} Box */

/** A point, with its name unless that would cover another. @param {CanvasRenderingContext2D} context @param {readonly [number, number]} place
 *  @param {string} name @param {string} color @param {number} scale @param {Box[]} names those that stand */
function point(context, [x, y], name, color, scale, names) {
  context.beginPath();
  context.arc(x, y, 0.25 * scale, 0, 2 * Math.PI);
  context.fillStyle = color;
  context.fill();
  const [left, half] = [x + 0.4 * scale, 0.45 * scale];
  const right = left + context.measureText(name).width;
  if (names.some((other) => left < other[2] && right > other[0] && y - half < other[3] && y + half > other[1])) return;
  names.push([left, y - half, right, y + half]);
  context.lineWidth = 0.2 * scale;
  context.strokeStyle = "#0a0e14";
  context.strokeText(name, x + 0.4 * scale, y);
  context.fillText(name, x + 0.4 * scale, y);
}

/** Where the phone is, with two standard deviations round it. @param {CanvasRenderingContext2D} context @param {{x_m: number, y_m: number, sd_m: number}} me @param {At} at @param {number} scale */
function drawMe(context, me, at, scale) {
  const [x, y] = at(me.x_m, me.y_m);
  context.beginPath();
  context.arc(x, y, Math.max(2 * me.sd_m, 0.4) * scale, 0, 2 * Math.PI);
  context.fillStyle = "#45d6a044";
  context.fill();
  context.strokeStyle = "#45d6a0";
  context.lineWidth = 0.12 * scale;
  context.stroke();
  const heading = headingOnPlan();
  if (heading === null) return;
  context.save();
  context.translate(x, y);
  context.rotate((heading * Math.PI) / 180);
  context.beginPath();
  context.moveTo(0, -0.9 * scale);
  context.lineTo(0.4 * scale, 0.4 * scale);
  context.lineTo(-0.4 * scale, 0.4 * scale);
  context.fillStyle = "#45d6a0";
  context.fill();
  context.restore();
}
