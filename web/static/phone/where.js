/** Where am I, and the way there, from what the phone carries. As server/mission/whereabouts.py and routes.py answer. */

import { say } from "./texts.js";
import { bearingFrom, compassPoint, inMetres, lastOf, legOf, lengthOf, metres } from "./words.js";

/** @import {Roads} from "./roads.js" */
/** @import {End, NearVictim, Pocket, PocketTag, Route, Where} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

const NEAR_M = 20;
const GONE = ["dismissed", "extricated"];

/**
 * What is looked for: `tag:ID`, `victim:ID` or `note:ID`.
 * @param {Pocket} pocket @param {Roads} roads @param {string} to
 * @returns {{goal: string, place: [number, number] | null, ends: End[], isTag: boolean} | null} null where there is no such thing
 */
function goalOf(pocket, roads, to) {
  const [kind, ...rest] = to.split(":");
  const name = rest.join(":");
  const goal = say(/** @type {Key} */ (`goal_${kind}`), { name });
  if (kind === "tag") {
    const tag = roads.tags[roads.numbers.get(name) ?? -1];
    return tag ? { goal, place: [tag.x_m, tag.y_m], ends: [[name, 0]], isTag: true } : null;
  }
  const found = kind === "victim" ? pocket.victims.find(({ victim_id }) => victim_id === name)
    : pocket.notes.find(({ annotation_id }) => annotation_id === name);
  if (!found) return null;
  return { goal, place: found.x_m === null || found.y_m === null ? null : [found.x_m, found.y_m], ends: found.ends, isTag: false };
}

/**
 * @param {Pocket} pocket @param {Roads} roads @param {string} fromTag @param {string} to
 * @returns {Route | null} null where no way is known
 */
export function routeTo(pocket, roads, fromTag, to) {
  const target = goalOf(pocket, roads, to);
  const found = target && roads.route(fromTag, target.ends);
  if (!target?.place || !found) return null;
  let from = /** @type {number} */ (roads.numbers.get(fromTag));
  const legs = found.edges.map((edge) => {
    const leg = legOf(roads, from, edge);
    from = edge.to;
    return leg;
  });
  const last = target.isTag ? null : lastOf(roads, from, target.place, target.goal);
  return { legs, last, distance_m: [...legs, ...(last ? [last] : [])].reduce((sum, step) => sum + step.distance_m, 0) };
}

/** @param {Pocket} pocket @param {Roads} roads @param {string} tagId @returns {Where | null} */
export function whereIs(pocket, roads, tagId) {
  const tag = roads.tags[roads.numbers.get(tagId) ?? -1];
  if (!tag) return null;
  const victims = nearVictims(pocket, roads, tagId);
  const { mission_id, mission_name } = pocket;
  return { mission_id, mission_name, tag_id: tagId, sd_m: tag.sd_m, notice: tag.notice, text: textOf(roads, tag, victims), victims };
}

/** @param {Pocket} pocket @param {Roads} roads @param {string} tagId @returns {NearVictim[]} */
function nearVictims(pocket, roads, tagId) {
  const tag = roads.tags[/** @type {number} */ (roads.numbers.get(tagId))];
  /** @type {NearVictim[]} */
  const found = [];
  for (const { victim_id, status, merged_into, x_m, y_m } of pocket.victims) {
    if (GONE.includes(status) || merged_into) continue;
    const route = routeTo(pocket, roads, tagId, `victim:${victim_id}`);
    const straight_m = Math.hypot(x_m - tag.x_m, y_m - tag.y_m);
    if (straight_m > NEAR_M && !route) continue;
    found.push({ victim_id, status, distance_m: route ? route.distance_m : straight_m, reachable: route !== null });
  }
  return found.sort((a, b) => Number(b.reachable) - Number(a.reachable) || a.distance_m - b.distance_m);
}

/** @param {Roads} roads @param {PocketTag} tag @param {NearVictim[]} victims */
function textOf(roads, { tag_id: tag, place_kind: kind }, victims) {
  const words = [kind ? say("you_are_in", { tag, place: say(/** @type {Key} */ (`in_${kind}`)) }) : say("you_are_at", { tag })];
  const there = roads.neighbours(tag).slice(0, 2).map((edge) => {
    const points = inMetres(edge.points);
    const way = compassPoint(bearingFrom(roads.north, points[1][0] - points[0][0], points[1][1] - points[0][1]), roads.north);
    return say("next_to_it", { far: metres(lengthOf(points)), way, tag: roads.tags[edge.to].tag_id });
  });
  if (there.length) words.push(`${there.join("; ")}.`);
  const near = victims.filter(({ distance_m }) => distance_m <= NEAR_M).length;
  if (near) words.push(say("victims_near", { n: near, count: countOf(near), far: metres(NEAR_M) }));
  else words.push(victims.length ? say("nearest_victim", { far: metres(victims[0].distance_m) }) : say("no_victim"));
  return words.join(" ");
}

/** @param {number} n */
const countOf = (n) => (n < 10 ? say(/** @type {Key} */ (`count_${n}`)) : String(n));
