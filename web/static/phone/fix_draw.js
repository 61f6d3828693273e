/** Where the phone may be by the nodes it hears, drawn on the plan: an ellipse for each place, or a ring. */

import { state } from "./state.js";
import { rightTo } from "./fix_words.js";

/** @import {At} from "./plan.js" */

const COLOR = "#c792ff";
const FAINT = "#c792ff33";

/** What has to be on the plan round a point, in metres. @param {{x_m: number, y_m: number}} me */
export function reachOfFix(me) {
  const { fix } = state;
  const node = fix?.ring && nodeOf(fix.ring.node_id);
  const far = (/** @type {{x_m: number, y_m: number}} */ { x_m, y_m }) => Math.hypot(x_m - me.x_m, y_m - me.y_m);
  if (fix?.ring && node) return far(node) + fix.ring.range_m + fix.ring.sd_m;
  return Math.max(0, ...(fix?.places ?? []).map((place) => far(place) + rightTo(place)));
}

/** @param {string} id */
const nodeOf = (id) => state.roads?.tags[state.roads.numbers.get(id) ?? -1];

/** @param {CanvasRenderingContext2D} context @param {At} at @param {number} scale */
export function drawFix(context, at, scale) {
  const { fix } = state;
  if (!fix) return;
  const node = fix.ring && nodeOf(fix.ring.node_id);
  if (fix.ring && node) {
    const [x, y] = at(node.x_m, node.y_m);
    context.beginPath();
    context.arc(x, y, fix.ring.range_m * scale, 0, 2 * Math.PI);
    context.strokeStyle = FAINT;
    context.lineWidth = 2 * Math.min(2 * fix.ring.sd_m, fix.ring.range_m) * scale;
    context.stroke();
    outline(context, scale, 1);
  }
  fix.places.forEach(({ x_m, y_m, var_x, var_xy, var_y, share }) => {
    const [middle, half] = [(var_x + var_y) / 2, Math.hypot((var_x - var_y) / 2, var_xy)];
    const axes = [middle + half, middle - half].map((variance) => Math.max(2 * Math.sqrt(Math.max(0, variance)), 0.3) * scale);
    // the plan's x is up and its y is left: a direction seen from x towards y turns left from up
    const turn = -Math.PI / 2 - Math.atan2(2 * var_xy, var_x - var_y) / 2;
    context.beginPath();
    context.ellipse(...at(x_m, y_m), axes[0], axes[1], turn, 0, 2 * Math.PI);
    context.fillStyle = FAINT;
    context.fill();
    outline(context, scale, share);
  });
}

/** What is less likely is dashed. @param {CanvasRenderingContext2D} context @param {number} scale @param {number} share */
function outline(context, scale, share) {
  context.strokeStyle = COLOR;
  context.lineWidth = 0.12 * scale;
  context.setLineDash(share > 0.6 ? [] : [0.4 * scale, 0.3 * scale]);
  context.stroke();
  context.setLineDash([]);
}
