/** Routes over the ways that a phone carries: Dijkstra 1959, as robots/routes/planner.py, to the same centimetre. */

import { hazardsOf, isNear } from "./hazards.js";

/** @import {Pocket, PocketNote, PocketWay, End} from "./types.js" */
/** @typedef {{way: PocketWay, points: number[], to: number, cost: number, hazards: string[]}} Edge */
/** By the number of a tag what it costs to get there, the edge that leads there, and from which tag.
 *  @typedef {{from: number, costs: Float64Array, before: (Edge | undefined)[], origins: Int32Array}} Tree */

const HAZARD_COST_CM = 5000;

export class Roads {
  /** @param {Pocket} pocket @param {PocketNote[]} notes also those that this phone has not sent yet */
  constructor(pocket, notes = pocket.notes) {
    this.tags = pocket.tags;
    /** True bearing of the plan's x axis; null where nobody has said how the plan lies on the Earth. */
    this.north = pocket.x_axis_deg ?? null;
    /** @type {Map<string, number>} */
    this.numbers = new Map(pocket.tags.map((tag, k) => [tag.tag_id, k]));
    const order = pocket.tags.map((_, k) => k).sort((a, b) => (pocket.tags[a].tag_id < pocket.tags[b].tag_id ? -1 : 1));
    /** Places in the order of names: of equals the first counts. */
    this.ranks = new Int32Array(order.length);
    order.forEach((k, rank) => (this.ranks[k] = rank));
    /** @type {Edge[][]} */
    this.next = pocket.tags.map(() => []);
    this.notes = notes;
    this.hazards = hazardsOf(notes);
    for (const way of pocket.ways) {
      const [a, b, cm, points, narrow_cm] = way;
      const found = this.hazardsNear(points);
      const cost = cm + narrow_cm + HAZARD_COST_CM * found.length;
      this.next[a].push({ way, points, to: b, cost, hazards: found });
      this.next[b].push({ way, points: reversed(points), to: a, cost, hazards: found });
    }
    /** @type {Tree | null} */
    this.tree = null;
  }

  /** What a line passes. @param {number[]} points x, y, x, y, ... in cm */
  hazardsNear(points) {
    return this.hazards.filter((hazard) => isNear(points, hazard)).map(({ text }) => text);
  }

  /** The shortest ways from a tag to all others. @param {number} from @returns {Tree} */
  from(from) {
    if (this.tree?.from === from) return this.tree;
    const count = this.tags.length;
    const costs = new Float64Array(count).fill(Infinity);
    /** @type {(Edge | undefined)[]} */
    const before = new Array(count);
    const origins = new Int32Array(count).fill(-1);
    const done = new Uint8Array(count);
    const queue = new Queue(this.ranks);
    costs[from] = 0;
    queue.put(from, 0);
    for (let item = queue.take(); item; item = queue.take()) {
      const tag = item.tag;
      if (done[tag]) continue;
      done[tag] = 1;
      for (const edge of this.next[tag]) {
        const total = costs[tag] + edge.cost;
        if (total >= costs[edge.to]) continue;
        costs[edge.to] = total;
        before[edge.to] = edge;
        origins[edge.to] = tag;
        queue.put(edge.to, total);
      }
    }
    this.tree = { from, costs, before, origins };
    return this.tree;
  }

  /**
   * The edges to the best of some ends, null where no way leads to any.
   * @param {string} fromTag
   * @param {End[]} ends tags and the centimetres still to go from there
   * @returns {{edges: Edge[], end: End} | null}
   */
  route(fromTag, ends) {
    const from = this.numbers.get(fromTag);
    if (from === undefined) return null;
    const tree = this.from(from);
    /** @type {{cost: number, tag: number, end: End} | null} */
    let best = null;
    for (const end of ends) {
      const tag = this.numbers.get(end[0]);
      if (tag === undefined || tree.costs[tag] === Infinity) continue;
      const cost = tree.costs[tag] + end[1];
      if (!best || cost < best.cost || (cost === best.cost && this.ranks[tag] < this.ranks[best.tag])) best = { cost, tag, end };
    }
    if (!best) return null;
    /** @type {Edge[]} */
    const edges = [];
    for (let tag = best.tag; tag !== from; tag = tree.origins[tag]) edges.push(/** @type {Edge} */ (tree.before[tag]));
    return { edges: edges.reverse(), end: best.end };
  }

  /** Edges to the tags next to a tag, the shortest first. @param {string} tagId */
  neighbours(tagId) {
    const edges = this.next[this.numbers.get(tagId) ?? -1] ?? [];
    return [...edges].sort((a, b) => a.way[2] - b.way[2] || this.ranks[a.to] - this.ranks[b.to]);
  }
}

/** A heap of tags by what it costs to get there; of equals the first by name. */
class Queue {
  /** @param {Int32Array} ranks */
  constructor(ranks) {
    this.ranks = ranks;
    /** @type {{tag: number, cost: number}[]} */
    this.items = [];
  }

  /** @param {{tag: number, cost: number}} a @param {{tag: number, cost: number}} b */
  isBefore(a, b) {
    return a.cost < b.cost || (a.cost === b.cost && this.ranks[a.tag] < this.ranks[b.tag]);
  }

  /** @param {number} tag @param {number} cost */
  put(tag, cost) {
    const { items } = this;
    const item = { tag, cost };
    let k = items.push(item) - 1;
    for (let up = (k - 1) >> 1; k > 0 && this.isBefore(item, items[up]); k = up, up = (k - 1) >> 1) items[k] = items[up];
    items[k] = item;
  }

  take() {
    const { items } = this;
    const first = items[0];
    const last = items.pop();
    if (!items.length || !last) return first;
    let k = 0;
    for (;;) {
      let down = 2 * k + 1;
      if (down >= items.length) break;
      if (down + 1 < items.length && this.isBefore(items[down + 1], items[down])) down += 1;
      if (!this.isBefore(items[down], last)) break;
      items[k] = items[down];
      k = down;
    }
    items[k] = last;
    return first;
  }
}

/** @param {number[]} points */
function reversed(points) {
  const back = [];
  for (let k = points.length - 2; k >= 0; k -= 2) back.push(points[k], points[k + 1]);
  return back;
}
