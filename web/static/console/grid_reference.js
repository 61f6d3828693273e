/**
 * Squares of ten metres with a short name to say over the radio, "C04": the letter counts along x, the number along y.
 *
 * Both count from the mission's origin and begin again below it (Z comes before A, 99 before 00), so that a name stays
 * what it is however the map grows; it is unique within 260 m along x and 1000 m along y.
 */

import { color } from "../theme.js";

/** @import {View} from "./canvas_layer.js" */

const SQUARE_M = 10;
const SMALLEST_PX = 70;
const TOOLS_PX = 52; // what lies over the plan, above and below

/** @param {number} x_m @param {number} y_m */
export function gridReference(x_m, y_m) {
  /** @param {number} value @param {number} count */
  const wrapped = (value, count) => ((Math.floor(value / SQUARE_M) % count) + count) % count;
  return `${String.fromCharCode(65 + wrapped(x_m, 26))}${String(wrapped(y_m, 100)).padStart(2, "0")}`;
}

/**
 * The names, each in the corner of what is seen of its square, while there is room for them.
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 */
export function drawGridReference(ctx, view) {
  const side = SQUARE_M * view.scale;
  if (side < SMALLEST_PX) return;
  ctx.font = `700 ${Math.round(13 * view.text)}px system-ui, sans-serif`;
  ctx.textBaseline = "top";
  ctx.fillStyle = color("text-faint");
  ctx.strokeStyle = color("text-faint");
  ctx.globalAlpha = 0.35;
  ctx.lineWidth = 1;
  const left = Math.floor(-view.toX(0) / side);
  const low = Math.floor((view.toY(0) - view.height) / side);
  ctx.beginPath();
  for (let column = left; view.toX(column * SQUARE_M) < view.width; column += 1) {
    ctx.moveTo(view.toX(column * SQUARE_M), 0);
    ctx.lineTo(view.toX(column * SQUARE_M), view.height);
  }
  for (let row = low; view.toY(row * SQUARE_M) > 0; row += 1) {
    ctx.moveTo(0, view.toY(row * SQUARE_M));
    ctx.lineTo(view.width, view.toY(row * SQUARE_M));
  }
  ctx.stroke();
  ctx.globalAlpha = 0.9;
  for (let column = left; view.toX(column * SQUARE_M) < view.width; column += 1) {
    for (let row = low; view.toY((row + 1) * SQUARE_M) > -side; row += 1) {
      const [x_m, y_m] = [column * SQUARE_M, row * SQUARE_M];
      const y = Math.max(TOOLS_PX, view.toY(y_m + SQUARE_M)) + 5;
      const isSeen = y < view.height - TOOLS_PX && y + 20 < view.toY(y_m);
      if (isSeen) ctx.fillText(gridReference(x_m, y_m), Math.max(0, view.toX(x_m)) + 5, y);
    }
  }
  ctx.globalAlpha = 1;
}
