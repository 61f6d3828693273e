/** Edges of the unknown on the plan: where each robot could go, and where it is going. */

import { robotColor } from "./color.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */

const SMALLEST_PX = 2.5;
const LARGEST_PX = 7;

/**
 * Rings as large as the edge is long; faint unless their robot is selected, and filled where it goes.
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
export function drawFrontiers(ctx, view, store) {
  const chosenRobot = store.selected?.kind === "robot" ? store.selected.id : null;
  for (const { robot_id, frontiers } of store.frontiers.values()) {
    const isSelected = robot_id === chosenRobot;
    ctx.globalAlpha = isSelected ? 0.95 : chosenRobot ? 0.2 : 0.45;
    ctx.strokeStyle = ctx.fillStyle = robotColor(robot_id);
    ctx.lineWidth = isSelected ? 2 : 1.25;
    for (const { x_m, y_m, length_m, chosen } of frontiers) {
      const [x, y] = [view.toX(x_m), view.toY(y_m)];
      if (x < -10 || y < -10 || x > view.width + 10 || y > view.height + 10) continue;
      const radius = Math.min(LARGEST_PX, Math.max(SMALLEST_PX, 1.5 + 0.9 * length_m));
      ctx.beginPath();
      ctx.arc(x, y, radius, 0, 2 * Math.PI);
      ctx.stroke();
      if (!chosen) continue;
      ctx.beginPath();
      ctx.arc(x, y, Math.max(1.5, radius - 2.5), 0, 2 * Math.PI);
      ctx.fill();
    }
  }
  ctx.globalAlpha = 1;
}
