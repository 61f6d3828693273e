/** The values of a mission's board by kind and id: as they are now, or as they were. */

/** @import {Alert, Annotation, Evacuation, MapInfo, Mission, MissionEvent, Node} from "./types.js" */
/** @import {Frontiers, Orders, Period, Person, Photo, Robot, Sector, Tag, Trail, Victim} from "./types.js" */

export class BoardState {
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
  /** @type {Map<string, Sector>} */
  sectors = new Map();
  /** @type {Map<string, Period>} */
  periods = new Map();
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
  /** People with a phone: which tag each read last. @type {Map<string, {name: string, tag_id: string, unix_s: number}>} */
  responders = new Map();
  /** @type {[string, string][]} */
  links = [];
  /** @type {MapInfo | null} */
  map = null;
  /** What was there before the mission. @type {MapInfo | null} */
  baseMap = null;
  /** Where the mission lies, once somebody has said. @type {import("./earth.js").Georeference | null} */
  georeference = null;
  /** Kind in a board key -> what has an id of that kind. @type {Record<string, Map<string, any>>} */
  keyed = {
    robot: this.robots, trail: this.trails, tag: this.tags, victim: this.victims, annotation: this.annotations,
    event: this.events, node: this.nodes, alert: this.alerts, person: this.people, responder: this.responders,
    frontiers: this.frontiers, orders: this.orders, photo: this.photos, sector: this.sectors, period: this.periods,
  };

  clear() {
    for (const map of Object.values(this.keyed)) map.clear();
    this.mission = null;
    this.evacuation = null;
    this.links = [];
    this.map = null;
    this.baseMap = null;
    this.georeference = null;
  }

  /**
   * @param {string} key
   * @param {any} value null when the key is gone
   */
  put(key, value) {
    const slash = key.indexOf("/");
    const [kind, id] = slash < 0 ? [key, ""] : [key.slice(0, slash), key.slice(slash + 1)];
    if (Object.hasOwn(this.keyed, kind)) {
      if (value === null) this.keyed[kind].delete(id);
      else this.keyed[kind].set(id, value);
    } else if (kind === "mission") this.mission = value;
    else if (kind === "evacuation") this.evacuation = value;
    else if (kind === "links") this.links = value?.pairs ?? [];
    else if (kind === "map") this.map = value;
    else if (kind === "base_map") this.baseMap = value;
    else if (kind === "georeference") this.georeference = value;
  }
}
