/** What is drawn over the building in lines: metre grid, links, trails, plan of the selected robot, tags. */

import { color } from "../theme.js";
import { robotColor } from "./color.js";
import { ellipse } from "./format.js";
import { drawFrontiers } from "./frontiers.js";
import { drawGridReference } from "./grid_reference.js";
import { isDoubted } from "./labels.js";
import { drawAreas } from "./notes.js";
import { drawResponders } from "./responders.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */


const CLOSE_PX_PER_M = 16;
const GRID_STEPS_M = [1, 5, 10, 50, 100, 500];

/**
 * Lines every 1, 5, 10, ... metres, never closer than 24 pixels.
 * @param {Store} store
 */
export const drawGround = (store) =>
  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   */
  (ctx, view) => {
    if (store.layers.reference) drawGridReference(ctx, view);
    if (!store.layers.grid) return;
    const step_m = GRID_STEPS_M.find((step) => step * view.scale >= 24) ?? 1000;
    ctx.lineWidth = 1;
    ctx.strokeStyle = color("grid");
    ctx.beginPath();
    const left = Math.floor((0 - view.toX(0)) / view.scale / step_m) * step_m;
    for (let x_m = left; view.toX(x_m) < view.width; x_m += step_m) {
      const x = Math.round(view.toX(x_m)) + 0.5;
      ctx.moveTo(x, 0);
      ctx.lineTo(x, view.height);
    }
    const bottom = Math.floor((view.toY(0) - view.height) / view.scale / step_m) * step_m;
    for (let y_m = bottom; view.toY(y_m) > 0; y_m += step_m) {
      const y = Math.round(view.toY(y_m)) + 0.5;
      ctx.moveTo(0, y);
      ctx.lineTo(view.width, y);
    }
    ctx.stroke();
  };

/** @param {Store} store */
export const drawInk = (store) =>
  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   */
  (ctx, view) => {
    ctx.lineJoin = ctx.lineCap = "round";
    if (store.layers.links) drawLinks(ctx, view, store);
    if (store.layers.notes) drawAreas(ctx, view, store);
    if (store.layers.trails) drawTrails(ctx, view, store);
    if (store.layers.frontiers && !store.best.isShown) drawFrontiers(ctx, view, store);
    if (store.layers.plans) drawPlan(ctx, view, store);
    if (store.layers.tags) drawTags(ctx, view, store);
    if (store.layers.responders) drawResponders(ctx, view, store);
  };

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
function drawLinks(ctx, view, store) {
  ctx.strokeStyle = color("tag");
  ctx.globalAlpha = 0.3;
  ctx.lineWidth = 1;
  ctx.beginPath();
  const { links, tags } = store.shown;
  for (const [first, second] of links) {
    const a = tags.get(first);
    const b = tags.get(second);
    if (!a || !b) continue;
    ctx.moveTo(view.toX(a.x_m), view.toY(a.y_m));
    ctx.lineTo(view.toX(b.x_m), view.toY(b.y_m));
  }
  ctx.stroke();
  ctx.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
function drawTrails(ctx, view, store) {
  for (const trail of store.shown.trails.values()) {
    const isSelected = store.isSelectedRobot(trail.robot_id);
    ctx.globalAlpha = isSelected ? 0.95 : store.selected?.kind === "robot" ? 0.35 : 0.6;
    ctx.lineWidth = isSelected ? 2.5 : 1.75;
    ctx.strokeStyle = robotColor(trail.robot_id);
    stroke(ctx, view, trail.points_m);
  }
  ctx.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
function drawPlan(ctx, view, store) {
  const robot = store.selected?.kind === "robot" ? store.shown.robots.get(store.selected.id) : undefined;
  if (!robot) return;
  const own = robotColor(robot.robot_id);
  if (robot.path_m?.length) {
    /** @type {[number, number][]} */
    const path = [[robot.x_m, robot.y_m], ...robot.path_m];
    ctx.strokeStyle = color("halo");
    ctx.lineWidth = 5;
    stroke(ctx, view, path);
    ctx.setLineDash([7, 6]);
    ctx.strokeStyle = own;
    ctx.lineWidth = 2.5;
    stroke(ctx, view, path);
    ctx.setLineDash([]);
  }
  if (!robot.goal_m) return;
  const [x, y] = [view.toX(robot.goal_m[0]), view.toY(robot.goal_m[1])];
  for (const [style, width] of /** @type {const} */ ([[color("halo"), 6], [own, 2.5]])) {
    ctx.strokeStyle = style;
    ctx.lineWidth = width;
    ctx.beginPath();
    ctx.arc(x, y, 8, 0, 2 * Math.PI);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      ctx.moveTo(x + 5 * dx, y + 5 * dy);
      ctx.lineTo(x + 12 * dx, y + 12 * dy);
    }
    ctx.stroke();
  }
}

/**
 * Tags that are not where all readings put them: hollow, dashed and larger, so that no colour is needed to tell.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {{x: number, y: number}[]} drawn
 * @param {number} radius
 */
function drawDoubtedTags(ctx, drawn, radius) {
  ctx.beginPath();
  for (const { x, y } of drawn) diamond(ctx, x, y, radius);
  ctx.lineWidth = 4;
  ctx.stroke();
  ctx.strokeStyle = color("doubted");
  ctx.lineWidth = 1.5;
  ctx.setLineDash([3, 2]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
function diamond(ctx, x, y, radius) {
  ctx.moveTo(x, y - radius);
  ctx.lineTo(x + radius, y);
  ctx.lineTo(x, y + radius);
  ctx.lineTo(x - radius, y);
  ctx.closePath();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
function drawTags(ctx, view, store) {
  const radius = Math.min(5.5, Math.max(2, view.scale * 0.14));
  const isClose = view.scale >= CLOSE_PX_PER_M;
  const drawn = [];
  const taken = new Set();
  for (const tag of store.shown.tags.values()) {
    const [x, y] = [view.toX(tag.x_m), view.toY(tag.y_m)];
    if (x < -40 || y < -40 || x > view.width + 40 || y > view.height + 40) continue;
    // Far out, tags nearer than six pixels would only make a smear: the first one stands for its neighbours.
    const place = `${Math.round(x / 6)} ${Math.round(y / 6)}`;
    if (!isClose && taken.has(place)) continue;
    taken.add(place);
    drawn.push({ tag, x, y });
    if (isClose && store.layers.uncertainty) drawTagEllipse(ctx, view, x, y, tag.covariance);
  }
  ctx.fillStyle = color("tag");
  ctx.strokeStyle = color("halo");
  ctx.lineWidth = 2;
  ctx.beginPath();
  for (const { tag, x, y } of drawn) if (!isDoubted(tag)) diamond(ctx, x, y, radius);
  ctx.stroke();
  ctx.fill();
  drawDoubtedTags(ctx, drawn.filter(({ tag }) => isDoubted(tag)), radius + 1.5);
  if (store.selected?.kind === "tag") drawSelected(ctx, drawn.find(({ tag }) => tag.tag_id === store.selected?.id));
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {number} x
 * @param {number} y
 * @param {number[]} covariance
 */
function drawTagEllipse(ctx, view, x, y, covariance) {
  const { major_m, minor_m, angle_rad } = ellipse(covariance);
  if (major_m * view.scale < 6) return;
  ctx.fillStyle = ctx.strokeStyle = color("tag");
  ctx.lineWidth = 1;
  ctx.beginPath();
  ctx.ellipse(x, y, major_m * view.scale, minor_m * view.scale, -angle_rad, 0, 2 * Math.PI);
  ctx.globalAlpha = 0.08;
  ctx.fill();
  ctx.globalAlpha = 0.4;
  ctx.stroke();
  ctx.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {{x: number, y: number} | undefined} place
 */
function drawSelected(ctx, place) {
  if (!place) return;
  ctx.strokeStyle = color("tag");
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.arc(place.x, place.y, 11, 0, 2 * Math.PI);
  ctx.stroke();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {[number, number][]} points
 */
function stroke(ctx, view, points) {
  ctx.beginPath();
  points.forEach(([x_m, y_m], index) => {
    if (index) ctx.lineTo(view.toX(x_m), view.toY(y_m));
    else ctx.moveTo(view.toX(x_m), view.toY(y_m));
  });
  ctx.stroke();
}
