/** People with a phone: a ring round the tag that each read last. */

import { color } from "../theme.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */

/** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Store} store */
export function drawResponders(ctx, view, store) {
  for (const { tag_id } of store.responders.values()) {
    const tag = store.shown.tags.get(tag_id);
    if (!tag) continue;
    ctx.beginPath();
    ctx.arc(view.toX(tag.x_m), view.toY(tag.y_m), 10, 0, 2 * Math.PI);
    for (const [ink, width] of /** @type {const} */ ([["halo", 6], ["good", 3]])) {
      ctx.strokeStyle = color(ink);
      ctx.lineWidth = width;
      ctx.stroke();
    }
  }
}
