/** People with a phone: the tag that each read last, and how long ago. */

import { color } from "../theme.js";
import { age } from "./format.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */

/**
 * A ring with the name beside the tag; those at one tag stand below each other.
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
export function drawResponders(ctx, view, store) {
  ctx.font = `700 ${Math.round(12 * view.text)}px system-ui, sans-serif`;
  ctx.textBaseline = "middle";
  const count = new Map();
  for (const { name, tag_id, unix_s } of store.responders.values()) {
    const tag = store.shown.tags.get(tag_id);
    if (!tag) continue;
    const row = count.get(tag_id) ?? 0;
    count.set(tag_id, row + 1);
    const [x, y] = [view.toX(tag.x_m), view.toY(tag.y_m)];
    ctx.strokeStyle = color("halo");
    ctx.lineWidth = 6;
    ctx.beginPath();
    ctx.arc(x, y, 10, 0, 2 * Math.PI);
    ctx.stroke();
    ctx.strokeStyle = color("good");
    ctx.lineWidth = 3;
    ctx.stroke();
    const [signed] = name.split(" (sent by ");  // by whose log-in stands with the report
    const words = `${signed}, ${age(Math.max(0, store.serverNow() - unix_s))}`;
    const at = y + 20 + 15 * row * view.text;
    ctx.strokeStyle = color("halo");
    ctx.lineWidth = 4;
    ctx.strokeText(words, x + 8, at);
    ctx.fillStyle = color("good");
    ctx.fillText(words, x + 8, at);
  }
}
