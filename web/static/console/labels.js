/** The names on the plan: what each says, how much it matters, and where it stands among the others. */

import { color } from "../theme.js";
import { robotColor } from "./color.js";
import { age, percent } from "./format.js";
import { LabelPlaces } from "./label_places.js";
import { alarming, alertByTag, isOpen } from "./node_sensors.js";
import { placeOf } from "./note_place.js";
import { sectorName } from "./sectors.js";

/** @import {Alert, Annotation, Node, Robot, Tag, Victim} from "./types.js" */
/** @import {Block, Place, Wish} from "./label_places.js" */
/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */

/**
 * A name at x, y in metres: `gap` and `half` (of the mark) in rem, `width` at most so wide; drawn in `ink` where it is no element.
 * @typedef {{key: string, rank: number, x_m: number, y_m: number, text: string, font: Font, gap: number, sides: string[],
 *   half?: number, most?: number, ink?: string, isForced?: boolean}} Name
 * @typedef {{css: string, size: number, height: number, pad: number}} Font size, height and padding in rem
 */

const RANK = { danger: 0, victim: 1, selected: 2, robot: 3, person: 4, tag: 5, rest: 6 };
const TAG_NAMES_FROM_PX_PER_M = 10;
const BELOW = ["s", "n", "e", "w", "se", "sw", "ne", "nw"];
const ABOVE = ["n", "s", "e", "w", "ne", "nw", "se", "sw"];
const BESIDE = ["e", "w", "n", "s", "ne", "se", "nw", "sw"];
const FACE = 'Inter, system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
const MONO = "ui-monospace, SFMono-Regular, Menlo, Consolas, monospace";
const MARK = { css: `650 %px ${FACE}`, size: 0.82, height: 1.15, pad: 0.7 };
const TAG = { css: `600 %px ${MONO}`, size: 0.69, height: 0.8, pad: 0.2 };
const PERSON = { css: `700 %px ${FACE}`, size: 0.75, height: 0.95, pad: 0.2 };
const SECTOR = { css: `700 %px ${FACE}`, size: 0.88, height: 1.1, pad: 0.2 };
const MARGIN_PX = 60;
const MOST_WIDTHS = 3000;

/** @param {Robot} robot */
export const robotWords = (robot) => (robot.stopped ? `${robot.robot_id} STOP` : robot.robot_id);

/** @param {Victim} victim */
export const victimWords = (victim) => `${victim.victim_id} · ${percent(victim.confidence)}`;

/** @param {Alert} alert @param {Store} store */
export const alertWords = (alert, store) => `${alert.tag_id} · ${alarming(alert, store.nodes.get(alert.tag_id ?? ""))}`;

/** @param {Annotation} note */
export const noteWords = (note) => note.text || note.kind;

/** @param {Tag} tag */
export const isDoubted = (tag) => (tag.state ?? "sound") !== "sound";

/** @param {Tag} tag @param {Node | undefined} node */
function tagWords(tag, node) {
  const id = isDoubted(tag) ? `${tag.tag_id} ${tag.state}` : tag.tag_id;
  const perMin = node?.temperature_c_per_min;
  const arrow = perMin == null || Math.abs(perMin) < 0.5 ? "" : perMin > 0 ? "↑" : "↓";
  return node?.temperature_c == null ? id : `${id} ${Math.round(node.temperature_c)}°${arrow}`;
}

/** How large a robot's mark is, pixels. @param {number} scale pixels a metre */
export const robotSize = (scale) => Math.min(60, Math.max(26, 0.7 * scale));

export class Labels {
  #places = new LabelPlaces();
  /** @type {Map<string, Place>} */
  #placed = new Map();
  /** @type {Name[]} */
  #inked = [];
  /** @type {Map<string, number>} */
  #widths = new Map();
  #measure = /** @type {CanvasRenderingContext2D | null} */ (document.createElement("canvas").getContext("2d"));

  /** @param {Store} store @param {import("leaflet").Map} map */
  constructor(store, map) {
    this.store = store;
    this.map = map;
  }

  /** Place all names anew. @param {string} pointed the tag under the cursor */
  arrange(pointed) {
    const scale = 2 ** this.map.getZoom();
    const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    const view = this.#view();
    const seen = namesOf(this.store, scale, rem, pointed).filter(({ x_m, y_m }) =>
      x_m * scale > view.left - MARGIN_PX && x_m * scale < view.right + MARGIN_PX
      && -y_m * scale > view.top - MARGIN_PX && -y_m * scale < view.bottom + MARGIN_PX);
    /** @param {Name} name */
    const at = ({ key, x_m, y_m }) => ({ key, x: x_m * scale, y: -y_m * scale });
    const wishes = seen.filter(({ text }) => text).map((name) => ({
      ...at(name), rank: name.isForced ? Math.min(name.rank, RANK.selected) : name.rank, width: this.#width(name, rem),
      height: name.font.height * rem, gap: name.gap * rem, sides: name.sides, isForced: name.isForced,
      isBold: name.isForced || name.rank <= RANK.robot }));
    const blocks = seen.filter(({ half }) => half).map((name) => ({ ...at(name), half: (name.half ?? 0) * rem }));
    this.#placed = this.#places.arrange(wishes, blocks, view);
    this.#inked = seen.filter(({ key, ink }) => ink && this.#placed.has(key));
  }

  /** Where a name stands, none where it was left out. @param {string} key */
  at(key) {
    return this.#placed.get(key);
  }

  /** Write the names that are no elements. @param {CanvasRenderingContext2D} ctx @param {View} view */
  draw(ctx, view) {
    ctx.textBaseline = "middle";
    ctx.textAlign = "center";
    ctx.lineJoin = "round";
    ctx.strokeStyle = color("halo");
    for (const { key, x_m, y_m, text, font, ink } of this.#inked) {
      const { dx, dy } = /** @type {Place} */ (this.#placed.get(key));
      ctx.font = fontOf(font, 16 * view.text);
      ctx.lineWidth = 4;
      ctx.strokeText(text, view.toX(x_m) + dx, view.toY(y_m) + dy);
      ctx.fillStyle = ink ?? "";
      ctx.fillText(text, view.toX(x_m) + dx, view.toY(y_m) + dy);
    }
  }

  /** What is seen, in pixels from the mission's origin: so panning moves no name. */
  #view() {
    const { x: width, y: height } = this.map.getSize();
    const { x, y } = this.map.latLngToContainerPoint([0, 0]);
    return { left: -x, top: -y, right: width - x, bottom: height - y };
  }

  /** @param {Name} name @param {number} rem */
  #width({ text, font, most }, rem) {
    const css = fontOf(font, rem);
    const key = `${css} ${text}`;
    let width = this.#widths.get(key);
    if (width === undefined) {
      if (this.#widths.size > MOST_WIDTHS) this.#widths.clear();
      if (this.#measure) this.#measure.font = css;
      width = this.#measure?.measureText(text).width ?? 0;
      this.#widths.set(key, width);
    }
    return Math.min(width + font.pad * rem, (most ?? Infinity) * rem);
  }
}

/** @param {Font} font @param {number} rem */
const fontOf = ({ css, size }, rem) => css.replace("%", (size * rem).toFixed(1));

/** @param {Store} store @param {number} scale @param {number} rem @param {string} pointed @returns {Name[]} */
function namesOf(store, scale, rem, pointed) {
  const { layers } = store;
  return [
    ...robotNames(store, robotSize(scale) / 2 / rem),
    ...(layers.victims ? victimNames(store) : []),
    ...(layers.sensors ? alertNames(store) : []),
    ...(layers.notes ? noteNames(store) : []),
    ...(layers.tags ? tagNames(store, scale, pointed) : []),
    ...(layers.responders ? peopleNames(store, pointed) : []),
    ...(layers.sectors ? sectorNames(store, scale) : []),
  ];
}

/** @param {Store} store @param {string} kind @param {string} id */
const isSelected = ({ selected }, kind, id) => selected?.kind === kind && selected.id === id;

/** @param {Store} store @param {number} half @returns {Name[]} */
function robotNames(store, half) {
  const { best } = store;
  const ends = best.isShown && store.layers.trails ? (best.content?.robots ?? []).filter(({ located }) => located) : [];
  return [
    ...[...store.shown.robots.values()].map((robot) => ({
      key: `robot/${robot.robot_id}`, rank: RANK.robot, x_m: robot.x_m, y_m: robot.y_m, text: robotWords(robot), font: MARK,
      gap: 1.1 * half + 0.1, half: 0.8 * half, sides: BELOW, isForced: isSelected(store, "robot", robot.robot_id) })),
    ...ends.map(({ robot_id, x_m, y_m }) => ({
      key: `end/${robot_id}`, rank: RANK.robot, x_m, y_m, text: robot_id, font: MARK, gap: 0.6, half: 0.5, sides: BESIDE,
      ink: robotColor(robot_id), isForced: isSelected(store, "robot", robot_id) })),
  ];
}

/** @param {Store} store @returns {Name[]} */
const victimNames = (store) => [...store.shown.victims.values()].filter(({ merged_into }) => !merged_into).map((victim) => ({
  key: `victim/${victim.victim_id}`, rank: victim.status === "dismissed" ? RANK.rest : RANK.victim, x_m: victim.x_m, y_m: victim.y_m,
  text: victimWords(victim), font: MARK, gap: 1.1, half: 0.95, sides: ABOVE, isForced: isSelected(store, "victim", victim.victim_id) }));

/** @param {Store} store @returns {Name[]} */
const alertNames = (store) => [...alertByTag(store)].flatMap(([id, alert]) => {
  const tag = store.shown.tags.get(id);
  return tag ? [{
    key: `alert/${id}`, rank: isOpen(alert) ? RANK.danger : RANK.tag, x_m: tag.x_m, y_m: tag.y_m, text: alertWords(alert, store), font: MARK,
    gap: 1, half: 0.85, sides: BELOW, isForced: isSelected(store, "tag", id) }] : [];
});

/** @param {Store} store @returns {Name[]} */
const noteNames = (store) => [...store.annotations].flatMap(([id, note]) => {
  const [x_m, y_m] = placeOf(note, store.shown.tags.get(note.tag_id ?? ""));
  return x_m == null || y_m == null ? [] : [{
    key: `note/${id}`, rank: note.kind === "hazard" ? RANK.danger : RANK.rest, x_m, y_m, text: noteWords(note), font: MARK, most: 12,
    gap: 0.85, half: 0.75, sides: BELOW, isForced: isSelected(store, "note", id) }];
});

/**
 * Of all tags from near, of the one that is pointed at or selected from anywhere.
 * @param {Store} store @param {number} scale @param {string} pointed @returns {Name[]}
 */
function tagNames(store, scale, pointed) {
  const { sensors } = store.layers;
  const alerted = sensors ? alertByTag(store) : new Map(); // an alert's mark has the name already
  return [...store.shown.tags.values()].flatMap((tag) => {
    const isForced = pointed === tag.tag_id || isSelected(store, "tag", tag.tag_id);
    if (alerted.has(tag.tag_id) || (scale < TAG_NAMES_FROM_PX_PER_M && !isForced)) return [];
    return [{
      key: `tag/${tag.tag_id}`, rank: RANK.tag, x_m: tag.x_m, y_m: tag.y_m, text: tagWords(tag, sensors ? store.nodes.get(tag.tag_id) : undefined),
      font: TAG, gap: 0.5, sides: BESIDE, ink: color(isDoubted(tag) ? "doubted" : "tag"), isForced }];
  });
}

/** All people whose last tag is the same share a line. @param {Store} store @param {string} pointed @returns {Name[]} */
function peopleNames(store, pointed) {
  const now = store.moment();
  /** @type {Map<string, {name: string, unix_s: number}[]>} */
  const byTag = new Map();
  for (const person of [...store.responders.values()].sort((a, b) => b.unix_s - a.unix_s)) {
    byTag.set(person.tag_id, [...(byTag.get(person.tag_id) ?? []), person]);
  }
  return [...byTag].flatMap(([id, people]) => {
    const tag = store.shown.tags.get(id);
    if (!tag) return [];
    const words = people.slice(0, 3).map(({ name, unix_s }) =>
      `${name.split(" (sent by ")[0]}, ${age(Math.max(0, now - unix_s))}`); // by whose log-in stands with the report
    return [{
      key: `person/${id}`, rank: RANK.person, x_m: tag.x_m, y_m: tag.y_m, text: words.join("; ") + (people.length > 3 ? ` and ${people.length - 3} more` : ""),
      font: PERSON, gap: 0.9, half: 0.75, sides: BELOW, ink: color("good"), isForced: id === pointed || isSelected(store, "tag", id) }];
  });
}

/** @param {Store} store @param {number} scale @returns {Name[]} */
const sectorNames = (store, scale) => [...store.sectors.values()].map((sector) => {
  const name = sectorName(sector, scale);
  return { ...name, key: `sector/${sector.sector_id}`, rank: RANK.rest, font: SECTOR, gap: 0.4, ink: color(name.ink),
    isForced: store.sectorPanel?.id === sector.sector_id };
});
