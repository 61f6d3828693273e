/** All that the page knows: the mission's board, the connection, and what the operator has chosen. */

import { BestMap } from "./best_map.js";

/** @import {Alert, Annotation, ConnectionState, Evacuation, MapInfo, Mission, MissionEvent, Node} from "./types.js" */
/** @import {Frontiers, Me, Orders, Person, Photo, Robot, Tag, Trail, Victim} from "./types.js" */

const PREFERENCES = "waymark.console";
const ROLES = ["viewer", "responder", "operator", "commander"];
const LATE_AFTER_S = 3;
const LOST_AFTER_S = 10;

/** Layers of the plan: name on screen and whether shown at first. */
export const LAYERS = /** @type {const} */ ({
  map: ["Building", true],
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
  photos: ["Photos", true],
});

/** @typedef {{kind: "robot" | "victim" | "tag" | "note", id: string}} Selected */

export class Store {
  /** @type {Mission | null} */
  mission = null;
  /** The order to leave, while it holds. @type {Evacuation | null} */
  evacuation = null;
  /** @type {Map<string, Robot>} */
  robots = new Map();
  /** @type {Map<string, Trail>} */
  trails = new Map();
  /** @type {Map<string, Tag>} */
  tags = new Map();
  /** @type {Map<string, Node>} */
  nodes = new Map();
  /** @type {Map<string, Alert>} */
  alerts = new Map();
  /** @type {Map<string, Victim>} */
  victims = new Map();
  /** @type {Map<string, Annotation>} */
  annotations = new Map();
  /** @type {Map<string, Photo>} */
  photos = new Map();
  /** @type {Map<string, MissionEvent>} */
  events = new Map();
  /** Where each robot could go. @type {Map<string, Frontiers>} */
  frontiers = new Map();
  /** The latest orders to each robot. @type {Map<string, Orders>} */
  orders = new Map();
  /** Who watches the mission. @type {Map<string, Person>} */
  people = new Map();
  /** People who read tags: which one last. @type {Map<string, {name: string, tag_id: string, since_unix_s: number, unix_s: number}>} */
  responders = new Map();
  /** Who is logged in here; null before that is known. @type {Me | null} */
  me = null;
  /** @type {[string, string][]} */
  links = [];
  /** @type {MapInfo | null} */
  map = null;
  /** Kind in a board key -> what has an id of that kind. @type {Record<string, Map<string, any>>} */
  keyed = {
    robot: this.robots, trail: this.trails, tag: this.tags, victim: this.victims, annotation: this.annotations,
    event: this.events, node: this.nodes, alert: this.alerts, person: this.people, responder: this.responders,
    frontiers: this.frontiers, orders: this.orders, photo: this.photos,
  };

  constructor() {
    this.best = new BestMap(this);
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
    /** The photo that is open. @type {string | null} */
    this.photo = null;
    /** Photos that are being sent. */
    this.uploads = 0;
    this.exploredM2 = 0;
    /** What the next click on the plan is for: whom it is about, and what is done with the place. */
    /** @type {{id: string, kind: string, then: (place: {x_m: number, y_m: number}) => void} | null} */
    this.picking = null;
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
    for (const map of Object.values(this.keyed)) map.clear();
    this.mission = null;
    this.evacuation = null;
    this.links = [];
    this.map = null;
    this.best.take(null);
  }

  /** What the plan draws: the board, or the best map in its place. @returns {import("./best_map.js").Layers} */
  get shown() {
    return this.best.isShown ? this.best.layers() : this;
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
    const slash = key.indexOf("/");
    const [kind, id] = slash < 0 ? [key, ""] : [key.slice(0, slash), key.slice(slash + 1)];
    if (Object.hasOwn(this.keyed, kind)) {
      if (value === null) this.keyed[kind].delete(id);
      else this.keyed[kind].set(id, value);
    } else if (kind === "mission") this.mission = value;
    else if (kind === "evacuation") this.evacuation = value;
    else if (kind === "links") this.links = value?.pairs ?? [];
    else if (kind === "map") this.map = value;
    else if (kind === "best_map") this.best.take(value);
  }

  /** Whether the mission is read and no longer changed. */
  get isOver() {
    return this.mission !== null && ["closed", "archived"].includes(this.mission.state);
  }

  /** Whether whoever is logged in here has this role or one above; the server decides. @param {string} role */
  may(role) {
    return !this.me?.login || ROLES.indexOf(this.me.role) >= ROLES.indexOf(role);
  }

  /** Time on the server's clock, seconds since 1970. */
  serverNow() {
    return Date.now() / 1000 + this.clockOffset_s;
  }

  /** Robots in the order of their names, r2 before r10. */
  robotList() {
    return [...this.robots.values()].sort((a, b) => a.robot_id.localeCompare(b.robot_id, "en", { numeric: true }));
  }

  /**
   * Seconds since the robot was last heard, and how good its link is: the worse of what the server says and what the
   * age says, for when our own stream is stale nobody tells us that a robot went quiet.
   * @param {Robot} robot
   */
  linkOf(robot) {
    const age_s = robot.heard_unix_s == null ? null : Math.max(0, this.serverNow() - robot.heard_unix_s);
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
