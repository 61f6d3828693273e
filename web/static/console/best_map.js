/**
 * The best map beside the live one: whether it is shown, how it stands, and what is in it once it was fetched.
 *
 * While it is shown, the plan draws its picture, tags, links, trails and victims' places in place of the live ones.
 */

import { missionPath, request } from "./api.js";

/** @import {BestMapContent, BestMapState, MapInfo, Robot, Tag, Trail, Victim} from "./types.js" */
/** @import {Store} from "./store.js" */

const RETRY_MS = 3000;
const MOVED_M = 0.5; // who drove less has hardly seen anything new
const STALE_M = 3; // a room's length: with robots under way it is never quite new, and that is no reason to warn

/**
 * What the plan draws, live or best.
 * @typedef {{map: MapInfo | null, robots: Map<string, Robot>, trails: Map<string, Trail>, tags: Map<string, Tag>,
 *   links: [string, string][], victims: Map<string, Victim>}} Layers
 */

export class BestMap {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    this.isShown = false;
    /** As the board has it; null while nobody has asked. @type {BestMapState | null} */
    this.state = null;
    /** What was fetched last. @type {BestMapContent | null} */
    this.fetched = null;
    this.drawn = layersOf(null);
    /** Why asking or fetching did not work, in a sentence. */
    this.trouble = "";
    this.asking = false;
    this.fetching = false;
  }

  /** Forget everything: another mission begins, live. */
  clear() {
    this.isShown = false;
    this.state = null;
    this.#keep(null);
    this.trouble = "";
  }

  /** What is in it; null before it was fetched, and when the server has none any more. */
  get content() {
    return this.state?.solved_unix_s ? this.fetched : null;
  }

  /** @param {BestMapContent | null} content */
  #keep(content) {
    this.fetched = content;
    this.drawn = layersOf(content);
  }

  /** @param {BestMapState | null} state the board's value */
  take(state) {
    this.state = state;
    if (state?.state === "solving") this.trouble = "";
    this.#fetch();
  }

  /** Show the best map; one is made where there is none or robots have seen more since. */
  show() {
    if (this.isShown || !this.store.mission || this.store.past.board) return;
    this.isShown = true;
    this.store.changed();
    if (this.isStale()) this.solve();
    this.#fetch();
  }

  showLive() {
    this.isShown = false;
    this.store.changed();
  }

  get isSolving() {
    return this.asking || this.state?.state === "solving";
  }

  /** Have it made, or join whoever has asked already. */
  async solve() {
    const { store } = this;
    const { missionId } = store;
    if (!missionId || this.isSolving) return;
    this.asking = true;
    this.trouble = "";
    store.changed();
    try {
      const state = await request("POST", `${missionPath(missionId)}/best-map`);
      // The stream may be ahead of this answer.
      if (missionId === store.missionId && !this.state) this.take(state);
    } catch (error) {
      if (missionId === store.missionId) this.trouble = /** @type {Error} */ (error).message;
    }
    this.asking = false;
    store.changed();
  }

  /** Whether there is none, or robots have reported since. */
  isStale() {
    return !this.state?.solved_unix_s || this.#newer().length > 0;
  }

  /** How far robots have driven since it was made, in metres; one that came later counts with its whole way. */
  drivenSince_m() {
    const left = new Set((this.state?.left_out ?? []).map((each) => each.robot_id)); // told apart
    return this.#newer().filter(([robot]) => !left.has(robot.robot_id))
      .reduce((sum, [robot, known_m]) => sum + Math.max(0, robot.distance_m - known_m), 0);
  }

  /** How much the robots have outrun it. @returns {"" | "a little" | "stale"} */
  outrun() {
    const driven_m = this.drivenSince_m();
    return driven_m >= STALE_M ? "stale" : driven_m >= MOVED_M ? "a little" : "";
  }

  /** Robots that have reported since, and how far each had driven then. @returns {[Robot, number][]} */
  #newer() {
    const known = new Map((this.state?.as_of ?? []).map((each) => [each.robot_id, each]));
    return [...this.store.robots.values()]
      .filter((robot) => robot.stamp_s > (known.get(robot.robot_id)?.stamp_s ?? -Infinity))
      .map((robot) => [robot, known.get(robot.robot_id)?.distance_m ?? 0]);
  }

  /**
   * The layers as the best map has them. Robots have none: where they are is known in the live map only, and that
   * differs by just what the best map corrects. Of victims it has the places; one that it does not know yet is shown
   * where the live map has it: off by a little is better than not there.
   * @returns {Layers}
   */
  layers() {
    if (!this.content) return layersOf(null);
    const { places, ...layers } = this.drawn;
    const victims = [...this.store.victims].map(([id, victim]) => /** @type {const} */ ([id, { ...victim, ...places.get(id) }]));
    return { ...layers, victims: new Map(victims) };
  }

  /** Bring the content to what the board announces, if somebody looks at it. */
  async #fetch() {
    const { store } = this;
    const { missionId } = store;
    const wanted = this.state?.solved_unix_s;
    if (!missionId || !this.isShown || !wanted || this.fetching || this.fetched?.solved_unix_s === wanted) return;
    this.fetching = true;
    try {
      const content = await request("GET", `${missionPath(missionId)}/best-map`);
      if (missionId === store.missionId) {
        this.trouble = "";
        this.#keep(content);
      }
    } catch (error) {
      if (missionId === store.missionId) this.trouble = `${/** @type {Error} */ (error).message} Trying again.`;
      setTimeout(() => this.#fetch(), RETRY_MS);
    }
    this.fetching = false;
    store.changed();
    if (!this.trouble) this.#fetch(); // another one may be there already
  }
}

/** @param {BestMapContent | null} content */
function layersOf(content) {
  return {
    map: content?.map ?? null,
    /** @type {Map<string, Robot>} */
    robots: new Map(),
    trails: new Map(content?.robots.map((robot) => [robot.robot_id, robot])),
    tags: new Map(content?.tags.map((tag) => [tag.tag_id, tag])),
    links: content?.links ?? [],
    /** @type {Map<string, Victim>} */
    victims: new Map(),
    places: new Map(content?.victims.map((victim) => [victim.victim_id, victim])),
  };
}
