/** Where am I, and the way there, from what the phone carries. As server/mission/whereabouts.py and routes.py answer. */

import { say } from "./texts.js";
import { bearingFrom, compassPoint, inMetres, lastOf, legOf, lengthAlong, metres } from "./words.js";

/** @import {Roads} from "./roads.js" */
/** @import {Words} from "./told.js" */
/** @import {End, NearVictim, Pocket, PocketTag, Route, Where} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

const NEAR_M = 20;
const GONE = ["dismissed", "extricated"];

/** `sd_m`: how well its place is known; `isAtTag`: reached with the tag. @typedef {{goal: string, place: [number, number], ends: End[], sd_m: number, isAtTag: boolean}} Goal */

/** @param {Key} key @param {string} name @param {{x_m: number | null, y_m: number | null, ends: End[], sd_m?: number}} found @param {string | null} [tag] that it is at @returns {Goal[]} */
function goal(key, name, { x_m, y_m, ends, sd_m = 0 }, tag = null) {
  if (x_m === null || y_m === null) return [];
  return [{ goal: say(key, { name }).trim(), place: [x_m, y_m], ends: tag === null ? ends : [[tag, 0]], sd_m, isAtTag: tag !== null }];
}

/**
 * What is looked for: `tag:ID`, `victim:ID`, `note:ID`, `exit:ID`, `exit` (all of them: the nearest is meant) or `base`.
 * @param {Pocket} pocket @param {Roads} roads @param {string} to
 * @returns {Goal[]} none where there is no such thing, or nobody knows where
 */
function goalsOf(pocket, roads, to) {
  const [kind, ...rest] = to.split(":");
  const name = rest.join(":");
  /** @param {string} tagId */
  const tagOf = (tagId) => roads.tags[roads.numbers.get(tagId) ?? -1];
  if (kind === "tag") return tagOf(name) ? goal("goal_tag", name, { ...tagOf(name), ends: [] }, name) : [];
  if (kind === "base") return pocket.base ? goal("goal_base", "", pocket.base, pocket.base.tag_id) : [];
  if (kind === "victim") return pocket.victims.filter(({ victim_id }) => victim_id === name).flatMap((found) => goal("goal_victim", name, found));
  if (kind === "note") return pocket.notes.filter(({ annotation_id }) => annotation_id === name).flatMap((found) => goal("goal_note", name, found));
  const exits = roads.notes.filter((note) => note.kind === "exit" && (to === "exit" || note.annotation_id === name));
  return exits.flatMap((exit) => {
    const tag = tagOf(exit.tag_id ?? "");
    return goal("goal_exit", exit.text, exit, tag && tag.x_m === exit.x_m && tag.y_m === exit.y_m ? exit.tag_id : null);
  });
}

/**
 * @param {Pocket} pocket @param {Roads} roads @param {string} fromTag @param {string} to as `goalsOf` takes it
 * @returns {Route | null} null where no way is known
 */
export function routeTo(pocket, roads, fromTag, to) {
  const goals = goalsOf(pocket, roads, to);
  const found = roads.route(fromTag, goals.flatMap(({ ends }) => ends));
  const target = found && goals.find(({ ends }) => ends.includes(found.end));
  if (!target || !found) return null;
  let from = /** @type {number} */ (roads.numbers.get(fromTag));
  const legs = found.edges.map((edge) => {
    const leg = legOf(roads, from, edge);
    from = edge.to;
    return leg;
  });
  const last = target.isAtTag ? null : lastOf(roads, from, target.place, target.goal, target.sd_m);
  return { goal: target.goal, legs, last, distance_m: [...legs, ...(last ? [last] : [])].reduce((sum, step) => sum + step.distance_m, 0) };
}

/** @param {Pocket} pocket @param {Roads} roads @param {string} tagId @returns {Where | null} */
export function whereIs(pocket, roads, tagId) {
  const tag = roads.tags[roads.numbers.get(tagId) ?? -1];
  if (!tag) return null;
  const victims = nearVictims(pocket, roads, tagId);
  const { mission_id, mission_name } = pocket;
  return { mission_id, mission_name, tag_id: tagId, sd_m: tag.sd_m, state: tag.state, notice: tag.notice, text: textOf(roads, tag, victims), victims };
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
    return say("next_to_it", { far: metres(lengthAlong(edge)), way, tag: roads.tags[edge.to].tag_id });
  });
  if (there.length) words.push(`${there.join("; ")}.`);
  const near = victims.filter(({ distance_m }) => distance_m <= NEAR_M).length;
  if (near) words.push(say("victims_near", { n: near, count: countOf(near), far: metres(NEAR_M) }));
  else words.push(victims.length ? say("nearest_victim", { far: metres(victims[0].distance_m) }) : say("no_victim"));
  return words.join(" ");
}

/** @param {number} n */
const countOf = (n) => (n < 10 ? say(/** @type {Key} */ (`count_${n}`)) : String(n));

/** A place as it is said at the top of the page. @param {Where} where @returns {Words} */
export function wordsOf({ tag_id, text, sd_m, state, notice }) {
  return {
    title: say("tag", { tag: tag_id }),
    text: sd_m > 1 ? `${text} ${say("place_unsure", { far: metres(sd_m) })}` : text,
    warning: notice && say(/** @type {Key} */ (`tag_${state ?? "doubtful"}`)),
  };
}
