/** What the phone shows, in one place, and who draws it again when it changes. */

/** @typedef {{victim_id: string, status: string, distance_m: number, reachable: boolean}} NearVictim */
/** @typedef {{mission_id: string, mission_name: string, tag_id: string, sd_m: number, notice: string, text: string,
 *   victims: NearVictim[]}} Where */
/** @typedef {{distance_m: number, bearing_deg: number, text: string, to_tag?: string, uncertain?: boolean}} Step */
/** @typedef {{distance_m: number, legs: Step[], last: Step | null}} Route */
/** @typedef {{ordered: boolean, by: string, acknowledged: {name: string}[]}} Evacuation */

export const state = {
  tagId: decodeURIComponent(location.pathname.split("/")[2] ?? ""),
  /** @type {Where | null} */ where: null,
  /** @type {Route | null} */ route: null,
  trouble: "",
  /** @type {"" | "word"} */ form: "",
  said: "",
  /** Compass heading of the phone, degrees from north; null where it tells none. @type {number | null} */ heading: null,
  /** @type {Evacuation | null} */ evacuation: null,
  /** @type {{name: string} | null} */ me: null,
  called: false,
  scanning: false,
  /** A tag's link of another server that was touched or scanned. @type {{tagId: string, host: string} | null} */ foreign: null,
  /** Tags that a typed number may mean. @type {string[]} */ choices: [],
};

/** @type {(() => void)[]} */
const drawers = [];

/** @param {() => void} draw called after every change */
export function onChange(draw) {
  drawers.push(draw);
}

/** @param {Partial<typeof state>} [change] */
export function changed(change = {}) {
  Object.assign(state, change);
  for (const draw of drawers) draw();
}
