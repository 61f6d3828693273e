/** What happened, as marks on the time bar: each kind has a shape of its own. */

import { missionPath, request } from "./api.js";

/** @import {MissionEvent} from "./types.js" */
/** @import {Store} from "./store.js" */

const PAGE = 1000;
const PLACES = 240; // marks of one kind closer than this part of the bar are one

/** Shapes in a square of 12. @type {Record<string, {label: string, path: string}>} */
export const SHAPES = {
  mayday: { label: "MAYDAY", path: "M6 0 12 11H0Z" },
  evacuate: { label: "EVACUATE", path: "M0 1h2.6v10H0ZM4.7 1h2.6v10H4.7ZM9.4 1H12v10H9.4Z" },
  stop: { label: "STOP", path: "M3.5 0h5L12 3.5v5L8.5 12h-5L0 8.5v-5Z" },
  victim: { label: "Victim", path: "M6 0a6 6 0 1 1 0 12A6 6 0 1 1 6 0Z" },
  alert: { label: "Alert", path: "M6 0 12 6 6 12 0 6Z" },
  order: { label: "Order", path: "M4.6 2h2.8v10H4.6Z" },
};

/** The shape of an event; none for what is no reason to jump there. @param {MissionEvent} event */
export function shapeOf({ kind, severity }) {
  if (kind === "mayday" || kind === "evacuate" || kind === "stop") return kind;
  if (kind.startsWith("victim")) return "victim";
  if (kind === "order" || kind === "order_failed") return "order";
  return severity === "info" ? "" : "alert";
}

export class TimeMarks {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    this.missionId = "";
    /** @type {Map<number, MissionEvent>} */
    this.events = new Map();
    /** @type {{key: string, marks: Mark[]}} */
    this.kept = { key: "", marks: [] };
  }

  /** @param {string} missionId */
  async open(missionId) {
    this.missionId = missionId;
    this.events.clear();
    try {
      for (let after = 0, more = true; more;) {
        const { events } = await request("GET", `${missionPath(missionId)}/events?after=${after}&limit=${PAGE}`);
        if (missionId !== this.missionId) return;
        for (const event of events) this.events.set(event.event_id, event);
        more = events.length === PAGE;
        after = events.at(-1)?.event_id ?? 0;
      }
    } catch {
      // What happens from now on comes with the stream; the rest of the bar works without marks.
    }
    this.store.changed();
  }

  /** Events worth a jump, oldest first. */
  worthy() {
    for (const event of this.store.live.events.values()) this.events.set(event.event_id, event);
    return [...this.events.values()].filter(shapeOf).sort((a, b) => a.unix_s - b.unix_s);
  }

  /** Marks for the bar, worked out anew when there are more events or a longer bar. @returns {Mark[]} */
  marks() {
    const { axis } = this.store.past;
    const events = this.worthy();
    const key = `${this.missionId} ${events.length} ${axis.length_s}`;
    if (key !== this.kept.key) this.kept = { key, marks: placed(events, axis) };
    return this.kept.marks;
  }

  /** The next event after a moment, or the last one before it. @param {number} unix_s @param {1 | -1} way */
  neighbour(unix_s, way) {
    const events = this.worthy();
    return way > 0 ? events.find((event) => event.unix_s > unix_s + 0.05) : events.findLast((event) => event.unix_s < unix_s - 0.05);
  }
}

/** @typedef {{event: MissionEvent, shape: string, share: number, count: number}} Mark */

/**
 * @param {MissionEvent[]} events
 * @param {import("./time_axis.js").Axis} axis
 * @returns {Mark[]}
 */
function placed(events, axis) {
  /** @type {Map<string, Mark>} */
  const marks = new Map();
  for (const event of events) {
    const share = axis.length_s ? axis.at(event.unix_s) / axis.length_s : 0;
    const shape = shapeOf(event);
    const place = `${shape} ${Math.round(PLACES * share)}`;
    const there = marks.get(place);
    if (there) there.count += 1;
    else marks.set(place, { event, shape, share, count: 1 });
  }
  return [...marks.values()];
}
