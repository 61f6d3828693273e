/** Distances and areas measured on the plan, corner by corner. */

import { color } from "../theme.js";
import { metres } from "./format.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */
/** @typedef {[number, number]} Point */

/** Length of a way, in metres. @param {Point[]} points */
export const lengthOf = (points) =>
  points.slice(1).reduce((sum, [x, y], k) => sum + Math.hypot(x - points[k][0], y - points[k][1]), 0);

/** Ground inside a ring of corners, in square metres (shoelace formula). @param {Point[]} points */
export function areaOf(points) {
  const twice = points.reduce((sum, [x, y], k) => {
    const [nx, ny] = points[(k + 1) % points.length];
    return sum + x * ny - nx * y;
  }, 0);
  return Math.abs(twice) / 2;
}

/** A click on the plan while something is measured. @param {Store} store @param {Point} point */
export function addPoint(store, point) {
  if (!store.measured) return false;
  store.measured.push(point);
  store.changed();
  return true;
}

/** @param {Store} store */
export function toggleMeasure(store) {
  store.measured = store.measured ? null : [];
  store.picking = store.draft = null;
  store.changed();
}

/** @param {{store: Store}} props */
export function MeasureTool({ store }) {
  const points = store.measured;
  const undo = () => { points?.pop(); store.changed(); };
  return html`<button type="button" class="tool measure" aria-expanded=${points !== null} onClick=${() => toggleMeasure(store)}
      title="Distances and areas (M)">Measure</button>
    ${points && html`<div class="draft measured" role="group" aria-label="Measured">
      <p role="status">${points.length < 2 ? "Click on the plan, corner by corner."
        : html`<b>${metres(lengthOf(points))}</b> long${points.length > 2 && html`, <b>${areaOf(points).toFixed(1)} m²</b> inside`}`}</p>
      ${points.length > 0 && html`<button type="button" onClick=${undo}>Take back a corner</button>`}</div>`}`;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Point[]} points
 */
export function drawMeasured(ctx, view, points) {
  if (!points.length) return;
  const at = points.map(([x_m, y_m]) => [view.toX(x_m), view.toY(y_m)]);
  ctx.beginPath();
  at.forEach(([x, y], k) => (k ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
  if (points.length > 2) {
    ctx.fillStyle = color("accent");
    ctx.globalAlpha = 0.12;
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  for (const [style, width] of /** @type {const} */ ([["halo", 5], ["accent", 2]])) {
    ctx.strokeStyle = color(style);
    ctx.lineWidth = width;
    ctx.stroke();
  }
  ctx.font = `600 ${Math.round(13 * view.text)}px system-ui, sans-serif`;
  ctx.textBaseline = "middle";
  ctx.lineWidth = 4;
  ctx.strokeStyle = color("halo");
  ctx.fillStyle = color("accent");
  at.forEach(([x, y], k) => {
    ctx.fillRect(x - 3, y - 3, 6, 6);
    if (!k) return;
    const text = metres(lengthOf([points[k - 1], points[k]]));
    const [mx, my] = [(x + at[k - 1][0]) / 2 + 6, (y + at[k - 1][1]) / 2 - 9];
    ctx.strokeText(text, mx, my);
    ctx.fillText(text, mx, my);
  });
}
