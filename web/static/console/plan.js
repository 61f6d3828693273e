/** The plan: a Leaflet map in metres, and how it follows what happens. */

import { Building } from "./building.js";
import { canvasLayer } from "./canvas_layer.js";
import { GroundLayers } from "./ground.js";
import { drawGround, drawInk } from "./ink.js";
import { Labels } from "./labels.js";
import { Marks } from "./marks.js";
import { drawEnds } from "./map_switch.js";
import { addPoint, drawMeasured } from "./measure.js";
import { placeOf } from "./note_place.js";
import { addCorner } from "./notes.js";
import { pickPlace } from "./robot_orders.js";
import { drawSectors, openSector, sectorAt } from "./sectors.js";
import { L } from "./vendor.js";

/** @import {Store} from "./store.js" */

const PANES = { ground: 150, base: 190, building: 200, layers: 210, ink: 420, reports: 610, robots: 620 };
const POINT_PX = 12;
const CLICK_PX = 18; // a finger is no pointer
const TOOLS_PX = 44;
const NARROW_PX = 900;
const CLOSE_ZOOM = 5.2; // about 37 pixels a metre: a room fills the view

export class Plan {
  /**
   * @param {HTMLElement} root
   * @param {Store} store
   */
  constructor(root, store) {
    this.store = store;
    /** Fit everything, follow the selected robot, or stay where the operator put it. */
    this.mode = /** @type {"fit" | "follow" | "free"} */ ("fit");
    /** @type {{x_m: number, y_m: number, tag: string} | null} */
    this.cursor = null;
    this.map = L.map(root, {
      crs: L.CRS.Simple,
      center: [0, 0],
      zoom: 4,
      minZoom: -2,
      maxZoom: 8,
      zoomSnap: 0,
      zoomDelta: 0.75,
      wheelPxPerZoomLevel: 140,
      wheelDebounceTime: 20,
      zoomControl: false,
      attributionControl: false,
      // Every layer is drawn anew in the same frame as the zoom, so nothing swims behind.
      zoomAnimation: false,
      fadeAnimation: false,
      markerZoomAnimation: false,
    });
    for (const [name, zIndex] of Object.entries(PANES)) {
      const pane = this.map.createPane(name);
      pane.style.zIndex = String(zIndex);
      if (["ground", "layers", "ink"].includes(name)) pane.style.pointerEvents = "none";
    }
    this.ground = canvasLayer("ground", drawGround(store)).addTo(this.map);
    this.sectors = canvasLayer("ink", drawSectors(store)).addTo(this.map);
    this.layers = new GroundLayers(this.map, store);
    this.told = canvasLayer("layers", (ctx, view) => this.layers.draw(ctx, view)).addTo(this.map);
    this.ink = canvasLayer("ink", drawInk(store)).addTo(this.map);
    this.ends = canvasLayer("ink", drawEnds(store)).addTo(this.map);
    this.labels = new Labels(store, this.map);
    this.names = canvasLayer("ink", (ctx, view) => {
      this.labels.draw(ctx, view);
      if (store.measured) drawMeasured(ctx, view, store.measured);
    }).addTo(this.map);
    this.building = new Building(this.map, store, {
      of: () => store.live.map,
      isShown: () => !store.best.isShown && !store.past.board,
    });
    this.base = new Building(this.map, store, {
      of: () => store.board.baseMap,
      isShown: () => true,
      layer: "base",
      pane: "base",
    }, 0);
    this.past = new Building(this.map, store, {
      of: () => store.past.board?.map ?? null,
      isShown: () => store.past.board !== null,
    }, 0);
    this.best = new Building(this.map, store, {
      of: () => store.best.content?.map ?? null,
      isShown: () => store.best.isShown,
    });
    this.marks = new Marks(this.map, store, this.labels, (selected) => store.select(selected));
    this.map.on("dragstart", () => this.#setMode("free"));
    root.addEventListener("wheel", () => this.mode === "fit" && this.#setMode("free"), { passive: true });
    this.map.on("zoom move", () => store.changed());
    this.map.on("mousemove", (event) => this.#point(event.latlng));
    this.map.on("click", (event) => {
      if (this.#take(event.latlng)) return;
      const id = this.#tagAt(event.latlng, CLICK_PX);
      if (id) store.select({ kind: "tag", id });
      const sector = id ? undefined : sectorAt(store, event.latlng.lng, event.latlng.lat);
      if (sector) openSector(store, sector.sector_id);
    });
    root.addEventListener("pointerdown", () => root.classList.remove("by-keys"), { capture: true });
    root.addEventListener("keydown", (event) => {
      root.classList.add("by-keys");
      if (event.target === root && event.key === "Enter") this.#take(this.map.getCenter());
    });
    this.map.on("mouseout", () => {
      this.cursor = null;
      store.changed();
    });
    new ResizeObserver(() => this.map.invalidateSize({ animate: false })).observe(root);
    store.subscribe(() => this.update());
  }

  update() {
    this.map.getContainer().classList.toggle("picking", this.isAsking());
    this.base.update();
    this.building.update();
    this.best.update();
    this.layers.update();
    this.told.refresh();
    this.past.update();
    this.labels.arrange(this.cursor?.tag ?? "");
    this.marks.update();
    this.ground.refresh();
    this.sectors.refresh();
    this.ink.refresh();
    this.ends.refresh();
    this.names.refresh();
    if (this.mode === "fit") this.#fit();
    if (this.mode === "follow") this.#follow();
  }

  /** Whether the next click on the plan is a place that somebody asks for. */
  isAsking() {
    const { picking, draft, measured } = this.store;
    return picking !== null || draft?.isArea === true || measured !== null;
  }

  /** The place for whatever asks for one; false when nothing does. @param {import("leaflet").LatLng} place */
  #take({ lng: x_m, lat: y_m }) {
    return pickPlace(this.store, { x_m, y_m }) || addCorner(this.store, [x_m, y_m]) || addPoint(this.store, [x_m, y_m]);
  }

  /** The middle of what is seen. */
  middle() {
    const { lng: x_m, lat: y_m } = this.map.getCenter();
    return { x_m, y_m };
  }

  /** Show the whole mission, and go on doing so while it grows. */
  fit() {
    this.#setMode("fit");
    this.#fit();
  }

  /** Keep the selected robot in the middle. */
  follow() {
    this.#setMode(this.mode === "follow" ? "free" : "follow");
    if (this.mode === "follow" && this.map.getZoom() < CLOSE_ZOOM) this.map.setZoom(CLOSE_ZOOM);
    this.store.changed();
  }

  /** @param {number} steps */
  zoom(steps) {
    if (this.mode === "fit") this.#setMode("free");
    this.map.setZoom(this.map.getZoom() + steps * 0.75);
  }

  /** @returns {[number, number] | undefined} where the selected thing is, x and y in metres */
  #selectedAt() {
    const { selected, best, robots, shown, annotations } = this.store;
    const id = selected?.id ?? "";
    const note = selected?.kind === "note" && annotations.get(id);
    if (note) return /** @type {[number, number]} */ (placeOf(note, shown.tags.get(note.tag_id ?? "")));
    const ends = new Map(best.content?.robots.map((robot) => [robot.robot_id, robot]));
    const thing = selected?.kind === "robot"
      ? (best.isShown ? ends : robots).get(id)
      : (selected?.kind === "tag" ? shown.tags : shown.victims).get(id);
    return thing && [thing.x_m, thing.y_m];
  }

  /** Put what is selected into the middle of the view. */
  centreOnSelected() {
    this.store.centred += 1;
    const place = this.#selectedAt();
    if (!place?.every(Number.isFinite)) return;
    if (this.mode === "fit") this.#setMode("free");
    this.map.setView([place[1], place[0]], Math.max(this.map.getZoom(), CLOSE_ZOOM - 0.7), { animate: false });
  }

  /** Pixels per metre. */
  scale() {
    return 2 ** this.map.getZoom();
  }

  /** @param {"fit" | "follow" | "free"} mode */
  #setMode(mode) {
    if (mode === this.mode) return;
    this.mode = mode;
    this.store.follows = mode === "follow";
    this.store.changed();
  }

  #fit() {
    // In the past too the whole building as it is known by now: what is looked at stays where it is.
    const { map: info, robots, victims } = this.store.past.board ? this.store.live : this.store.shown;
    const bounds = L.latLngBounds([]);
    if (info) {
      const [x_m, y_m] = info.origin_m;
      bounds.extend([y_m, x_m]);
      bounds.extend([y_m + info.height * info.resolution_m, x_m + info.width * info.resolution_m]);
    }
    for (const { x_m, y_m } of [...robots.values(), ...victims.values()]) {
      bounds.extend([y_m - 1.5, x_m - 1.5]);
      bounds.extend([y_m + 1.5, x_m + 1.5]);
    }
    if (!bounds.isValid()) return;
    const { x, y } = this.map.getSize();
    if (!x || !y) return;
    const pad = Math.min(56, 0.08 * Math.min(x, y));
    const above = Math.min(TOOLS_PX, 0.2 * y); // tools stand along the top, on a phone also below
    const below = innerWidth < NARROW_PX ? above : 0;
    const zoom = Math.min(6, this.map.getBoundsZoom(bounds, false, L.point(2 * pad, 2 * pad + above + below)));
    const centre = bounds.getCenter();
    const lower = (above - below) / 2;
    const moved = this.map.latLngToContainerPoint(centre).distanceTo([x / 2, y / 2 + lower]);
    if (moved <= 2 && Math.abs(zoom - this.map.getZoom()) <= 0.02) return;
    this.map.setView(this.map.unproject(this.map.project(centre, zoom).subtract([0, lower]), zoom), zoom, { animate: false });
  }

  #follow() {
    if (this.store.selected?.kind !== "robot") {
      this.#setMode("free");
      return;
    }
    const place = this.marks.shownAt(this.store.selected.id);
    if (!place) return;
    const { x, y } = this.map.getSize();
    if (this.map.latLngToContainerPoint(place).distanceTo([x / 2, y / 2]) > 1) {
      this.map.panTo(place, { animate: false });
    }
  }

  /** @param {import("leaflet").LatLng} place */
  #point(place) {
    this.cursor = { x_m: place.lng, y_m: place.lat, tag: this.#tagAt(place, POINT_PX) };
    this.store.changed();
  }

  /**
   * The nearest tag within so many pixels, or none.
   * @param {import("leaflet").LatLng} place
   * @param {number} reach_px
   */
  #tagAt(place, reach_px) {
    let tag = "";
    let nearest_m = reach_px / this.scale();
    if (this.store.layers.tags) {
      for (const each of this.store.shown.tags.values()) {
        const distance_m = Math.hypot(each.x_m - place.lng, each.y_m - place.lat);
        if (distance_m < nearest_m) [tag, nearest_m] = [each.tag_id, distance_m];
      }
    }
    return tag;
  }
}
