/** A Leaflet layer that is one canvas over the whole view, drawn anew whenever the view or the data changes. */

import { L } from "./vendor.js";

/**
 * Where world metres fall on the canvas; `text` is how much larger than usual words are.
 * @typedef {{scale: number, text: number, width: number, height: number, toX: (x_m: number) => number,
 *   toY: (y_m: number) => number}} View
 */

/**
 * @param {string} pane Leaflet pane to draw in
 * @param {(ctx: CanvasRenderingContext2D, view: View) => void} draw in CSS pixels
 * @returns {import("leaflet").Layer & {refresh: () => void}}
 */
export function canvasLayer(pane, draw) {
  const CanvasLayer = L.Layer.extend({
    options: { pane },

    /** @param {import("leaflet").Map} map */
    onAdd(map) {
      this.canvas = L.DomUtil.create("canvas", "canvas-layer", map.getPane(pane));
      map.on("move zoom viewreset resize", this.refresh, this);
      this.refresh();
    },

    /** @param {import("leaflet").Map} map */
    onRemove(map) {
      map.off("move zoom viewreset resize", this.refresh, this);
      L.Util.cancelAnimFrame(this.frame);
      this.frame = 0;
      this.canvas.remove();
    },

    refresh() {
      this.frame ||= requestAnimationFrame(() => this.paint());
    },

    paint() {
      this.frame = 0;
      const map = this._map;
      if (!map) return;
      const { x: width, y: height } = map.getSize();
      const ratio = window.devicePixelRatio || 1;
      const { canvas } = this;
      if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        canvas.style.width = `${width}px`;
        canvas.style.height = `${height}px`;
      }
      L.DomUtil.setPosition(canvas, map.containerPointToLayerPoint([0, 0]));
      const origin = map.latLngToContainerPoint([0, 0]);
      const scale = 2 ** map.getZoom();
      const ctx = canvas.getContext("2d");
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      ctx.clearRect(0, 0, width, height);
      draw(ctx, {
        scale, width, height,
        text: parseFloat(getComputedStyle(document.documentElement).fontSize) / 16,
        toX: (x_m) => origin.x + x_m * scale,
        toY: (y_m) => origin.y - y_m * scale,
      });
    },
  });
  return new /** @type {any} */ (CanvasLayer)();
}
