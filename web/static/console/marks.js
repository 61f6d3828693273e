/** Robots, victims, alerts and notes on the plan: real elements, so that they can be clicked, focused and read out. */

import { robotStyle } from "./color.js";
import { ellipse } from "./format.js";
import { alertWords, noteWords, robotSize, robotWords, victimWords } from "./labels.js";
import { noteShape, robotShape, victimShape } from "./mark_shapes.js";
import { ALERT_KINDS, alertByTag, isOpen } from "./node_sensors.js";
import { openPhoto, placedPhotos } from "./photos.js";
import { L } from "./vendor.js";
import { NOTE_KINDS } from "./note_kinds.js";
import { placeOf } from "./note_place.js";
import { statusOf } from "./victim_status.js";

/** @import {Alert, Annotation, Robot, Victim} from "./types.js" */
/** @import {Store} from "./store.js" */

const POINTED_AT = { dx: 0, dy: 28 }; // where a name without room comes up
const GLIDE_MS = 220; // poses come a few times a second: glide between them

/**
 * @typedef {{marker: import("leaflet").Marker, root: HTMLElement, parts: Record<string, HTMLElement | SVGElement>,
 *   from: number[], to: number[], startedAt: number, named: string}} Mark
 */

export class Marks {
  /**
   * @param {import("leaflet").Map} map
   * @param {Store} store
   * @param {import("./labels.js").Labels} labels
   * @param {(selected: {kind: "robot" | "victim" | "tag" | "note", id: string}) => void} onSelect
   */
  constructor(map, store, labels, onSelect) {
    this.map = map;
    this.store = store;
    this.labels = labels;
    this.onSelect = onSelect;
    /** @type {Map<string, Mark>} */
    this.marks = new Map();
    this.frame = 0;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    map.on("zoom viewreset", () => this.update());
  }

  update() {
    const { store } = this;
    const wanted = new Set();
    const { robots, victims } = store.shown;
    for (const robot of robots.values()) wanted.add(this.#robot(robot));
    if (store.layers.victims) {
      for (const victim of victims.values()) if (!victim.merged_into) wanted.add(this.#victim(victim));
    }
    if (store.layers.sensors) for (const alert of alertByTag(store).values()) wanted.add(this.#alert(alert));
    if (store.layers.notes) {
      for (const [id, annotation] of store.annotations) wanted.add(this.#note(id, annotation));
    }
    if (store.layers.photos) {
      for (const [key, group] of placedPhotos(store)) wanted.add(this.#photos(key, group));
    }
    for (const [key, mark] of this.marks) {
      if (wanted.has(key)) continue;
      mark.marker.remove();
      this.marks.delete(key);
    }
    this.#glide();
  }

  /** @param {string} robotId @returns {[number, number] | null} where the robot is drawn now, latitude first */
  shownAt(robotId) {
    const mark = this.marks.get(`robot/${robotId}`);
    if (!mark) return null;
    const [x_m, y_m] = interpolate(mark, performance.now());
    return [y_m, x_m];
  }

  /** @param {Robot} robot */
  #robot(robot) {
    const key = `robot/${robot.robot_id}`;
    const mark = this.marks.get(key) ?? this.#add(key, "robot", robotShape(robot.robot_id), () =>
      this.onSelect({ kind: "robot", id: robot.robot_id }));
    const { link } = this.store.linkOf(robot);
    mark.root.style.setProperty("--robot", robotStyle(robot.robot_id));
    mark.root.dataset.link = link;
    mark.root.dataset.robot = robot.robot_id;
    mark.root.classList.toggle("stopped", robot.stopped);
    mark.root.classList.toggle("selected", this.store.isSelectedRobot(robot.robot_id));
    this.#name(mark, key, robotWords(robot));
    mark.root.setAttribute("aria-label", `Robot ${robot.robot_id}, link ${link}${robot.stopped ? ", stopped" : ""}`);
    const scale = 2 ** this.map.getZoom();
    mark.root.style.setProperty("--size", `${robotSize(scale)}px`);
    shapeEllipse(mark.parts.sigma, robot.covariance, scale, this.store.layers.uncertainty);
    this.#moveTo(mark, [robot.x_m, robot.y_m, robot.yaw_rad]);
    return key;
  }

  /** @param {Victim} victim */
  #victim(victim) {
    const key = `victim/${victim.victim_id}`;
    const mark = this.marks.get(key) ?? this.#add(key, "victim", victimShape(), () =>
      this.onSelect({ kind: "victim", id: victim.victim_id }));
    const status = statusOf(victim.status);
    mark.root.dataset.status = victim.status;
    mark.root.dataset.victim = victim.victim_id;
    mark.parts.glyph.textContent = status.glyph;
    this.#name(mark, key, victimWords(victim));
    mark.root.classList.toggle(
      "selected", this.store.selected?.kind === "victim" && this.store.selected.id === victim.victim_id);
    mark.root.setAttribute(
      "aria-label", `Victim ${mark.parts.name.textContent} sure, ${status.label}`);
    shapeEllipse(mark.parts.sigma, victim.covariance, 2 ** this.map.getZoom(), this.store.layers.uncertainty);
    this.#moveTo(mark, [victim.x_m, victim.y_m, 0]);
    return key;
  }

  /** At the node that it is about, as far as the map has that. @param {Alert} alert */
  #alert(alert) {
    const tagId = alert.tag_id ?? "";
    const tag = this.store.shown.tags.get(tagId);
    const key = `alert/${tagId}`;
    if (!tag) return null;
    const mark = this.marks.get(key) ?? this.#add(key, "alert", noteShape(), () =>
      this.onSelect({ kind: "tag", id: tagId }));
    mark.root.dataset.severity = alert.severity;
    mark.root.dataset.alert = tagId;
    mark.root.classList.toggle("noted", !isOpen(alert));
    mark.parts.glyph.textContent = ALERT_KINDS[alert.kind]?.glyph ?? "!";
    this.#name(mark, key, alertWords(alert, this.store));
    mark.root.setAttribute("aria-label", `${mark.parts.name.textContent}: ${alert.text}`);
    this.#moveTo(mark, [tag.x_m, tag.y_m, 0]);
    return key;
  }

  /**
   * @param {string} id
   * @param {Annotation} annotation
   */
  #note(id, annotation) {
    const tag = annotation.tag_id ? this.store.shown.tags.get(annotation.tag_id) : undefined;
    const [x_m, y_m] = placeOf(annotation, tag);
    const key = `note/${id}`;
    if (x_m == null || y_m == null) return null;
    const mark = this.marks.get(key) ?? this.#add(key, "note", noteShape(), () =>
      this.onSelect({ kind: "note", id }));
    mark.root.classList.toggle("selected", this.store.selected?.kind === "note" && this.store.selected.id === id);
    mark.root.dataset.kind = annotation.kind;
    this.#name(mark, key, noteWords(annotation));
    mark.parts.glyph.textContent = NOTE_KINDS[annotation.kind]?.glyph ?? "i";
    mark.root.setAttribute("aria-label", `${annotation.kind}: ${annotation.text}`);
    this.#moveTo(mark, [x_m, y_m, 0]);
    return key;
  }

  /**
   * @param {string} subject
   * @param {{photos: import("./types.js").Photo[], x_m: number | null | undefined, y_m: number | null | undefined}} group
   */
  #photos(subject, { photos, x_m, y_m }) {
    if (x_m == null || y_m == null) return null;
    const key = `photo/${subject}`;
    const mark = this.marks.get(key) ?? this.#add(key, "photo-mark", noteShape(), () =>
      openPhoto(this.store, mark.root.dataset.photo ?? null));
    mark.root.dataset.photo = photos[0].photo_id;
    mark.parts.glyph.textContent = photos.length > 1 ? `▣ ${photos.length}` : "▣";
    mark.root.setAttribute("aria-label", photos.length > 1 ? `${photos.length} photos` : `Photo: ${photos[0].text || subject}`);
    this.#moveTo(mark, [x_m, y_m, 0]);
    return key;
  }

  /** What a mark is called, where there is room for it; else only while it is pointed at. @param {Mark} mark @param {string} key @param {string} words */
  #name(mark, key, words) {
    const place = this.labels.at(key);
    const named = `${place?.dx} ${place?.dy} ${words}`;
    if (named === mark.named) return;
    mark.named = named;
    mark.parts.name.textContent = words;
    mark.root.classList.toggle("unnamed", !place);
    const { dx, dy } = place ?? POINTED_AT;
    mark.parts.name.style.translate = `${dx.toFixed(1)}px ${dy.toFixed(1)}px`;
  }

  /**
   * @param {string} key
   * @param {string} kind
   * @param {Record<string, HTMLElement | SVGElement>} parts
   * @param {(() => void) | null} onSelect
   * @returns {Mark}
   */
  #add(key, kind, parts, onSelect) {
    const root = document.createElement("div");
    root.className = `mark ${kind}`;
    root.append(...Object.values(parts));
    const icon = L.divIcon({ html: root, className: "mark-anchor", iconSize: [0, 0] });
    const marker = L.marker([0, 0], { icon, pane: kind === "robot" ? "robots" : "reports", keyboard: false });
    marker.addTo(this.map);
    if (onSelect) {
      root.tabIndex = 0;
      root.setAttribute("role", "button");
      marker.on("click", onSelect);
      root.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        onSelect();
      });
    } else root.setAttribute("role", "img");
    /** @type {Mark} */
    const mark = { marker, root, parts, from: [], to: [], startedAt: 0, named: "" };
    this.marks.set(key, mark);
    return mark;
  }

  /**
   * @param {Mark} mark
   * @param {number[]} pose x, y, heading
   */
  #moveTo(mark, pose) {
    if (mark.to.every((value, index) => value === pose[index]) && mark.to.length) return;
    const now = performance.now();
    const isFirst = !mark.to.length;
    mark.from = isFirst || this.still.matches ? pose : interpolate(mark, now);
    mark.to = pose;
    mark.startedAt = now;
    if (isFirst || this.still.matches) place(mark, now);
  }

  /** Move all marks a frame further until each has arrived. */
  #glide() {
    if (this.frame) return;
    const step = () => {
      this.frame = 0;
      const now = performance.now();
      let isMoving = false;
      for (const mark of this.marks.values()) {
        if (!mark.startedAt) continue;
        place(mark, now);
        if (now - mark.startedAt < GLIDE_MS) isMoving = true;
        else mark.startedAt = 0;
      }
      if (isMoving) this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
  }
}

/**
 * @param {Mark} mark
 * @param {number} now
 */
function interpolate(mark, now) {
  const share = mark.startedAt ? Math.min(1, (now - mark.startedAt) / GLIDE_MS) : 1;
  const turn = Math.atan2(Math.sin(mark.to[2] - mark.from[2]), Math.cos(mark.to[2] - mark.from[2]));
  return [
    mark.from[0] + share * (mark.to[0] - mark.from[0]),
    mark.from[1] + share * (mark.to[1] - mark.from[1]),
    mark.from[2] + share * turn,
  ];
}

/**
 * @param {Mark} mark
 * @param {number} now
 */
function place(mark, now) {
  const [x_m, y_m, yaw_rad] = interpolate(mark, now);
  mark.marker.setLatLng([y_m, x_m]);
  mark.parts.arrow?.style.setProperty("transform", `translate(-50%, -50%) rotate(${Math.PI / 2 - yaw_rad}rad)`);
}

/**
 * @param {HTMLElement | SVGElement} element
 * @param {number[]} covariance
 * @param {number} scale pixels per metre
 * @param {boolean} isShown
 */
function shapeEllipse(element, covariance, scale, isShown) {
  const { major_m, minor_m, angle_rad } = ellipse(covariance);
  element.style.display = isShown && major_m * scale > 8 ? "" : "none";
  element.style.width = `${2 * major_m * scale}px`;
  element.style.height = `${2 * minor_m * scale}px`;
  element.style.transform = `translate(-50%, -50%) rotate(${-angle_rad}rad)`;
}
