/** The fused map of the building: fetched as a palette PNG, coloured here, laid on the plan cell by cell. */

import { rgb, shownTheme } from "../theme.js";
import { fetchChecked } from "./api.js";
import { L } from "./vendor.js";

/** @import {MapInfo} from "./types.js" */
/** @import {Store} from "./store.js" */

const SHORTEST_PAUSE_MS = 500;
const NOT_LOADED = "The building's map could not be loaded.";

export class Building {
  /**
   * @param {import("leaflet").Map} map
   * @param {Store} store
   * @param {{of: () => MapInfo | null, isShown: () => boolean, layer?: string, pane?: string,
   *   paint?: (pixels: Uint8ClampedArray, palette: number[][]) => void}} source which map, whether it is the one that
   *   is looked at, the layer it is if not the building itself and the pane for it, and what colours it otherwise than as a building
   * @param {number} [pause_ms] shortest time between two pictures
   */
  constructor(map, store, source, pause_ms = SHORTEST_PAUSE_MS) {
    this.map = map;
    this.store = store;
    this.source = source;
    this.pause_ms = pause_ms;
    this.canvas = document.createElement("canvas");
    this.canvas.className = "leaflet-image-layer building";
    /** @type {any} */
    this.overlay = null;
    this.loading = false;
    this.shownAddress = "";
    this.loadedAt = 0;
  }

  /** Bring the overlay to the latest version, at most twice a second, also while another map is looked at. */
  update() {
    const info = this.source.of();
    if (!info || !this.#isOn()) {
      this.overlay?.remove();
      if (!info) this.overlay = null, this.shownAddress = "";
      return;
    }
    this.#place();
    const address = `${info.png}#${info.version} ${shownTheme()}`;
    if (this.loading || address === this.shownAddress) return;
    this.loading = true;
    const pause_ms = Math.max(0, this.loadedAt + this.pause_ms - Date.now());
    setTimeout(() => this.#load(info, address), pause_ms);
  }

  /**
   * @param {MapInfo} info
   * @param {string} address
   */
  async #load(info, address) {
    try {
      const bytes = await (await fetchChecked(info.png)).arrayBuffer();
      const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
      this.#show(bitmap, paletteOf(new Uint8Array(bytes)), info);
      this.shownAddress = address;
      this.store.withdraw(NOT_LOADED);
    } catch (error) {
      // While the stream is down the veil says so already.
      if (this.store.connection.state === "live") {
        // A body that breaks off, or comes too late, is the browser's own error, in the browser's own words.
        const why = error instanceof DOMException ? "The server is slow to answer." : /** @type {Error} */ (error).message;
        this.store.notify(`${NOT_LOADED} ${why} It is tried again.`);
      }
    } finally {
      this.loading = false;
      this.loadedAt = Date.now();
    }
    this.store.changed();
  }

  /**
   * @param {ImageBitmap} bitmap
   * @param {number[][]} palette
   * @param {MapInfo} info as the image was asked for
   */
  #show(bitmap, palette, info) {
    const { canvas } = this;
    const { width, height } = bitmap;
    canvas.width = width;
    canvas.height = height;
    const ctx = canvas.getContext("2d", { willReadFrequently: true });
    if (!ctx) throw new Error("the browser gives no canvas.");
    ctx.drawImage(bitmap, 0, 0);
    bitmap.close();
    const image = ctx.getImageData(0, 0, width, height);
    (this.source.paint ?? paint)(image.data, palette);
    ctx.putImageData(image, 0, 0);

    const [x_m, y_m] = info.origin_m;
    /** @type {[number, number][]} */
    const bounds = [[y_m, x_m], [y_m + height * info.resolution_m, x_m + width * info.resolution_m]];
    if (this.overlay) this.overlay.setBounds(L.latLngBounds(bounds));
    else {
      this.overlay = L.imageOverlay("", bounds, { pane: this.source.pane ?? (this.source.layer ? "layers" : "building") });
      this.overlay._image = canvas; // an image overlay makes its own <img> unless it has an element already
    }
    this.#place();
  }

  #isOn() {
    return this.store.layers[this.source.layer ?? "map"];
  }

  /** Put the overlay on the plan, or take it off. */
  #place() {
    if (!this.overlay) return;
    const isWanted = this.#isOn() && this.source.isShown();
    if (isWanted !== this.map.hasLayer(this.overlay)) isWanted ? this.overlay.addTo(this.map) : this.overlay.remove();
  }
}

/**
 * Colours of a palette PNG's classes: unknown, free, occupied.
 * @param {Uint8Array} png
 * @returns {number[][]}
 */
export function paletteOf(png) {
  const view = new DataView(png.buffer, png.byteOffset, png.byteLength);
  for (let at = 8; at + 12 <= png.length;) {
    const length = view.getUint32(at);
    const name = String.fromCharCode(...png.subarray(at + 4, at + 8));
    if (name === "PLTE") {
      return Array.from({ length: length / 3 }, (_, entry) => [...png.subarray(at + 8 + 3 * entry, at + 11 + 3 * entry)]);
    }
    at += 12 + length;
  }
  throw new Error("the image has no palette.");
}

/**
 * Give every cell our own colours, by the class its colour stands for.
 * @param {Uint8ClampedArray} pixels RGBA, changed in place
 * @param {number[][]} palette
 */
export function paint(pixels, palette) {
  const [, free, occupied] = palette;
  const [floor, wall] = [rgb("floor"), rgb("wall")];
  for (let at = 0; at < pixels.length; at += 4) {
    if (pixels[at + 3] < 128) continue;
    const isWall = distance(pixels, at, occupied) < distance(pixels, at, free);
    const [r, g, b] = isWall ? wall : floor;
    pixels[at] = r;
    pixels[at + 1] = g;
    pixels[at + 2] = b;
  }
}

/**
 * @param {Uint8ClampedArray} pixels
 * @param {number} at
 * @param {number[]} color
 */
function distance(pixels, at, color) {
  return Math.abs(pixels[at] - color[0]) + Math.abs(pixels[at + 1] - color[1]) + Math.abs(pixels[at + 2] - color[2]);
}
