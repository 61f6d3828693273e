/** Layers that are asked for only while somebody looks at them: coverage, one robot's own map, contact, memories. */

import { color, rgb } from "../theme.js";
import { missionPath, request } from "./api.js";
import { Building } from "./building.js";
import { fixed, percent } from "./format.js";
import { html } from "./vendor.js";

/** @import {MapInfo} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */
/** @typedef {{map: MapInfo, free_m2: number, safe_m2: number, cleared_m2: number}} Coverage */
/** @typedef {{robots: {points_m: [number, number][], heard: boolean[]}[]}} Contact */
/** @typedef {{tags: {x_m: number, y_m: number, cell_m: number, window: string[]}[]}} Memories */

const AGAIN_MS = 3000;

/** Asks for one address again and again while it is wanted. @template T */
class Asked {
  /** @param {Store} store @param {() => string | null} address null while nobody looks */
  constructor(store, address) {
    this.store = store;
    this.address = address;
    /** @type {T | null} */
    this.value = null;
    this.from = "";
    this.askedAt = 0;
  }

  /** What was answered last to what is wanted now. @returns {T | null} */
  get now() {
    const address = this.address();
    if (address && Date.now() - this.askedAt > AGAIN_MS && this.store.connection.state === "live") this.#ask(address);
    return address === this.from ? this.value : null;
  }

  /** @param {string} address */
  async #ask(address) {
    this.askedAt = Date.now();
    try {
      this.value = await request("GET", address);
    } catch {
      this.value = null; // it is not there yet; where the server is gone the veil says so
    }
    this.from = address;
    this.store.changed();
  }
}

export class GroundLayers {
  /** @param {import("leaflet").Map} map @param {Store} store */
  constructor(map, store) {
    this.store = store;
    const wanted = (/** @type {string} */ layer, /** @type {string} */ path) => () =>
      (store.layers[layer] && store.mission && !store.best.isShown && !store.past.board ? `${missionPath(store.missionId ?? "")}${path}` : null);
    const robot = () => (store.selected?.kind === "robot" ? store.selected.id : null);
    /** @type {Asked<Coverage>} */
    this.coverage = new Asked(store, wanted("coverage", "/coverage"));
    /** @type {Asked<MapInfo>} */
    this.ownMap = new Asked(store, () => robot() && wanted("own", `/robots/${encodeURIComponent(robot() ?? "")}/map`)());
    /** @type {Asked<Contact>} */
    this.contact = new Asked(store, wanted("radio", "/contact"));
    /** @type {Asked<Memories>} */
    this.memories = new Asked(store, wanted("memories", "/memories"));
    this.pictures = [
      new Building(map, store, { of: () => this.coverage.now?.map ?? null, isShown: () => true, layer: "coverage", paint: paintCoverage }),
      new Building(map, store, { of: () => this.ownMap.now, isShown: () => true, layer: "own", paint: paintOwn }),
    ];
  }

  update() {
    for (const picture of this.pictures) picture.update();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {View} view */
  draw(ctx, view) {
    for (const { points_m, heard } of this.contact.now?.robots ?? []) drawContact(ctx, view, points_m, heard);
    const memories = this.memories.now;
    if (memories) drawMemories(ctx, view, memories);
  }
}

/** Every pixel in the colour of its class, see through. @param {Uint8ClampedArray} pixels @param {(red: number) => [number[], number]} of */
function tint(pixels, of) {
  for (let at = 0; at < pixels.length; at += 4) {
    if (pixels[at + 3] < 128) continue;
    const [tone, alpha] = of(pixels[at]);
    pixels.set([...tone, alpha], at);
  }
}

/** @param {Uint8ClampedArray} pixels @param {number[][]} palette */
function paintCoverage(pixels, palette) {
  const tones = new Map([[palette[1][0], [rgb("warn"), 60]], [palette[2][0], [rgb("seen"), 80]], [palette[3][0], [rgb("cleared"), 95]]]);
  tint(pixels, (red) => /** @type {[number[], number]} */ (tones.get(red) ?? [[0, 0, 0], 0]));
}

/** @param {Uint8ClampedArray} pixels @param {number[][]} palette */
function paintOwn(pixels, palette) {
  tint(pixels, (red) => (red === palette[2][0] ? [rgb("doubted"), 255] : [rgb("doubted"), 70]));
}

/** Where a robot was heard, and where only what it told later is known. */
/** @param {CanvasRenderingContext2D} ctx @param {View} view @param {[number, number][]} points @param {boolean[]} heard */
function drawContact(ctx, view, points, heard) {
  ctx.globalAlpha = 0.3;
  for (const isHeard of [true, false]) {
    ctx.fillStyle = color(isHeard ? "good" : "warn");
    ctx.beginPath();
    points.forEach(([x_m, y_m], k) => {
      if (heard[k] !== isHeard) return;
      const [x, y, radius] = [view.toX(x_m), view.toY(y_m), 0.5 * view.scale];
      ctx.moveTo(x + radius, y);
      ctx.arc(x, y, radius, 0, 2 * Math.PI);
    });
    ctx.fill();
  }
  ctx.globalAlpha = 1;
}

/**
 * Cells of all windows, each colour laid on once however many tags tell of a place. The first row of a window is
 * farthest along x, its first column farthest along y.
 * @param {CanvasRenderingContext2D} ctx @param {View} view @param {Memories} memories
 */
export function drawMemories(ctx, view, { tags }) {
  ctx.globalAlpha = 0.35;
  for (const [sign, tone] of [["o", "warn"], ["#", "seen"]]) {
    ctx.beginPath();
    for (const { x_m, y_m, cell_m, window } of tags) {
      const half_m = (window.length * cell_m) / 2;
      const side = cell_m * view.scale;
      window.forEach((row, r) => [...row].forEach((cell, c) => cell === sign
        && ctx.rect(view.toX(x_m + half_m - (r + 1) * cell_m), view.toY(y_m + half_m - c * cell_m), side, side)));
    }
    ctx.fillStyle = color(tone);
    ctx.fill();
  }
  ctx.globalAlpha = 1;
}

/** What the colours mean, while one of these layers is shown. @param {{layers: GroundLayers, store: Store}} props */
export function GroundKey({ layers, store }) {
  const coverage = layers.coverage.now;
  const shown = [
    coverage && [["cleared", `cleared of victims, ${fixed(coverage.cleared_m2, 0)} m² (${percent(coverage.cleared_m2 / coverage.free_m2)})`],
      ["seen", `a robot was near, ${fixed(coverage.safe_m2 - coverage.cleared_m2, 0)} m²`],
      ["warn", `seen from afar only, ${fixed(coverage.free_m2 - coverage.safe_m2, 0)} m²`]],
    store.layers.radio && [["good", "robots were heard here"], ["warn", "told of later: no radio"]],
    store.layers.memories && [["seen", "tags call it covered"], ["warn", "covered, with an open edge"]],
    layers.ownMap.now && [["doubted", `as ${store.selected?.id} alone has it`]],
  ].flatMap((each) => each || []);
  if (!shown.length) return null;
  return html`<ul class="ground-key" aria-label="What the colours of the ground mean">${shown.map(([name, words]) =>
    html`<li><i style=${{ background: `var(--${name})` }}></i>${words}</li>`)}</ul>`;
}
