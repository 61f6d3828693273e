/** All that the page knows: the mission's board, the connection, and what the operator has chosen. */

import { BestMap } from "./best_map.js";
import { BoardState } from "./board_state.js";
import { Past } from "./past.js";

/** @import {ConnectionState, Me, Mission, Robot} from "./types.js" */

const PREFERENCES = "waymark.console";
const ROLES = ["viewer", "responder", "operator", "commander"];
const LATE_AFTER_S = 2.5;
const LOST_AFTER_S = 10;

/** Layers of the plan: name on screen and whether shown at first. */
export const LAYERS = /** @type {const} */ ({
  map: ["Building", true],
  base: ["Base map", true],
  own: ["Selected robot's own map", false],
  coverage: ["Coverage: near, cleared", false],
  radio: ["Radio: where robots were heard", false],
  memories: ["Ground as tags tell it", false],
  grid: ["Metre grid", true],
  reference: ["Grid reference", false],
  trails: ["Trails", true],
  tags: ["Tags", true],
  sensors: ["Node sensors", true],
  links: ["Links between tags", true],
  uncertainty: ["Uncertainty (2σ)", true],
  frontiers: ["Edges of the unknown", true],
  plans: ["Plan of selected robot", true],
  victims: ["Victims", true],
  responders: ["People at tags", true],
  notes: ["Notes and hazards", true],
  sectors: ["Sectors", true],
  photos: ["Photos", true],
});

/** @typedef {{kind: "robot" | "victim" | "tag" | "note", id: string}} Selected */

export class Store {
  /** What the mission shows now. */
  live = new BoardState();
  /** Who is logged in here; null before that is known. @type {Me | null} */
  me = null;

  constructor() {
    this.best = new BestMap(this);
    this.past = new Past(this);
    /** @type {Mission[]} */
    this.missions = [];
    /** @type {string | null} */
    this.missionId = null;
    /** @type {{state: ConnectionState, heardAt: number, attempt: number, retryAt: number, reason: string}} */
    this.connection = { state: "loading", heardAt: Date.now(), attempt: 0, retryAt: 0, reason: "" };
    /** Difference between the server's clock and ours, in seconds. */
    this.clockOffset_s = 0;
    /** @type {Selected | null} */
    this.selected = null;
    /** @type {Map<number, {text: string, level: "warning" | "alarm"}>} */
    this.notices = new Map();
    /** Robots that are stopped together. @type {Set<string>} */
    this.group = new Set();
    /** The photo that is open. @type {string | null} */
    this.photo = null;
    /** What is being said of where the mission lies. @type {import("./georeference.js").Placing | null} */
    this.placing = null;
    /** Which sector is open, null in it for the list of all. @type {{id: string | null, trouble: string} | null} */
    this.sectorPanel = null;
    /** Photos that are being sent. */
    this.uploads = 0;
    /** What the next click on the plan is for: whom it is about, and what is done with the place. */
    /** @type {{id: string, kind: string, then: (place: {x_m: number, y_m: number}) => void} | null} */
    this.picking = null;
    /** Whether the views go along with what is selected, and how often that was put into their middle. */
    this.follows = false;
    this.centred = 0;
    /** What is being written on the map. @type {import("./notes.js").Draft | null} */
    this.draft = null;
    /** Corners of what is being measured, x and y in metres. @type {[number, number][] | null} */
    this.measured = null;
    const kept = readPreferences();
    /** @type {Record<string, boolean>} */
    this.layers = Object.fromEntries(
      Object.entries(LAYERS).map(([name, [, shown]]) => [name, kept.layers?.[name] ?? shown]),
    );
    /** @type {"plan" | "both" | "scene"} */
    this.view = kept.view ?? (innerWidth >= 1400 ? "both" : "plan");
    if (innerWidth < 900) this.view = "plan"; // a phone loads the 3D scene only when it is asked for
    this.split = kept.split ?? 0.58;
    this.tab = "robots";
    /** @type {Set<() => void>} */
    this.listeners = new Set();
    this.frame = 0;
    this.noticeCount = 0;
  }

  clearBoard() {
    this.live.clear();
    this.best.take(null);
  }

  /** What the page is about: the mission as it is, or as it was at the moment that is looked at. */
  get board() {
    return this.past.board ?? this.live;
  }

  get mission() { return this.board.mission; }
  get evacuation() { return this.board.evacuation; }
  get robots() { return this.board.robots; }
  get trails() { return this.board.trails; }
  get tags() { return this.board.tags; }
  get nodes() { return this.board.nodes; }
  get alerts() { return this.board.alerts; }
  get victims() { return this.board.victims; }
  get annotations() { return this.board.annotations; }
  get events() { return this.board.events; }
  get frontiers() { return this.board.frontiers; }
  get orders() { return this.board.orders; }
  get people() { return this.board.people; }
  get georeference() { return this.board.georeference; }
  get responders() { return this.board.responders; }
  get sectors() { return this.board.sectors; }
  get periods() { return this.board.periods; }
  get photos() { return this.board.photos; }
  get links() { return this.board.links; }
  get map() { return this.board.map; }
  /** Free floor that the team has on its map, in square metres. */
  get explored_m2() { return this.map?.explored_m2 ?? 0; }

  /** What the plan draws: the board, or the best map in its place. @returns {import("./best_map.js").Layers} */
  get shown() {
    return this.best.isShown ? this.best.layers() : this.board;
  }

  /** @param {() => void} listener called after changes, at most once a frame */
  subscribe(listener) {
    this.listeners.add(listener);
  }

  changed() {
    if (this.frame) return;
    const tell = () => {
      this.frame = 0;
      for (const listener of this.listeners) listener();
    };
    // A hidden page gets no frames, but its title and its alarms must go on.
    this.frame = document.hidden ? setTimeout(tell, 250) : requestAnimationFrame(tell);
  }

  /**
   * @param {Record<string, any>} set board keys and their new values
   * @param {string[]} deleted board keys that are gone
   */
  apply(set, deleted) {
    for (const [key, value] of Object.entries(set)) this.#put(key, value);
    for (const key of deleted) this.#put(key, null);
    this.changed();
  }

  /**
   * @param {string} key
   * @param {any} value null when the key is gone
   */
  #put(key, value) {
    if (key === "best_map") this.best.take(value);
    else this.live.put(key, value);
  }

  /** Whether what is shown is read and cannot be changed: the past, and a mission that is over. */
  get isOver() {
    return this.past.board !== null || ["closed", "archived"].includes(this.live.mission?.state ?? "");
  }

  /** Whether whoever is logged in here has this role or one above; the server decides. @param {string} role */
  may(role) {
    return !this.me?.login || ROLES.indexOf(this.me.role) >= ROLES.indexOf(role);
  }

  /** Time on the server's clock, seconds since 1970. */
  serverNow() {
    return Date.now() / 1000 + this.clockOffset_s;
  }

  /** The moment that is looked at, seconds since 1970: now, or one of the past. */
  moment() {
    return this.past.at_s ?? this.serverNow();
  }

  /** Robots in the order of their names, r2 before r10. */
  robotList() {
    return [...this.robots.values()].sort((a, b) => a.robot_id.localeCompare(b.robot_id, "en", { numeric: true }));
  }

  /**
   * Seconds since the robot was last heard, and how good its link is: the worse of what the server says and what the
   * age says, for when our own stream is stale nobody tells us that a robot went quiet.
   * @param {Robot} robot
   * @param {number} [moment] seconds since 1970
   */
  linkOf(robot, moment = this.moment()) {
    const age_s = robot.heard_unix_s == null ? null : Math.max(0, moment - robot.heard_unix_s);
    const isLost = robot.link === "lost" || (age_s !== null && age_s > LOST_AFTER_S);
    const isLate = robot.link === "late" || (age_s !== null && age_s > LATE_AFTER_S);
    return { link: isLost ? "lost" : isLate ? "late" : robot.link, age_s };
  }

  /** @param {Selected | null} selected */
  select(selected) {
    this.selected = selected;
    this.changed();
  }

  /** @param {string} id */
  isSelectedRobot(id) {
    return this.selected?.kind === "robot" && this.selected.id === id;
  }

  /**
   * @param {string} text
   * @param {"warning" | "alarm"} level
   */
  notify(text, level = "warning") {
    if ([...this.notices.values()].some((notice) => notice.text === text)) return;
    this.notices.set(++this.noticeCount, { text, level });
    if (this.notices.size > 4) this.notices.delete(/** @type {number} */ (this.notices.keys().next().value));
    this.changed();
  }

  /** Take back what is no longer so. @param {string} beginning of the notices' texts */
  withdraw(beginning) {
    for (const [number, { text }] of this.notices) if (text.startsWith(beginning)) this.notices.delete(number);
    this.changed();
  }

  /** Keep layers, view and split for the next visit. */
  keepPreferences() {
    try {
      localStorage.setItem(
        PREFERENCES, JSON.stringify({ layers: this.layers, view: this.view, split: this.split }));
    } catch {
      // Private browsing may forbid it; the page works without.
    }
    this.changed();
  }
}

function readPreferences() {
  try {
    return JSON.parse(localStorage.getItem(PREFERENCES) ?? "{}") ?? {};
  } catch {
    return {};
  }
}
