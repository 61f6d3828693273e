/** A tag was read: answer from what the phone carries, at once; then ask for the newest. */

import { begin, walkedFrom } from "./between.js";
import { pocketOf } from "./carried.js";
import { takeOrder } from "./evacuate.js";
import { language } from "./language.js";
import { add, onOutbox, waiting } from "./outbox.js";
import { cameFrom, judged } from "./pace.js";
import { isOver, keptOf, missionOf, missions, opened, refresh, refreshAll } from "./pockets.js";
import { reach, read, remember, remembered } from "./reach.js";
import { Roads } from "./roads.js";
import { sentBeyond } from "./sent.js";
import { changed, missionId, state } from "./state.js";
import { say } from "./texts.js";
import { routeTo, whereIs } from "./where.js";

/** @import {Pocket, PocketNote} from "./types.js" */

const FRESH_MS = 15_000;
const SHIFT_S = 43_200; // who read no tag for so long may be in another mission by now
const IS_TAG = /^[A-Za-z0-9][A-Za-z0-9._:~-]*$/; // as server/schemas/common.py
const TARGET = "waymark.target"; // where this phone is being led
const LAST = "waymark.last";
const SEEN = "waymark.seen"; // the tags that this phone really read, and when

/** The tag this phone was at last and the one before, since when by its clock, its mission ("" where not known), and whether that was reported.
 * @returns {{tag: string, before: string, mission: string, since_s: number, isTold: boolean} | null} */
export const lastTag = () => remembered(LAST);

/** Where this phone is being led: kept over reloads, none when it is another mission's.
 * @returns {{mission: string, to: string, whole_m: number} | null} */
export function target() {
  const kept = remembered(TARGET);
  return kept && kept.mission === state.where?.mission_id ? kept : null;
}

/** @param {string | null} to `victim:ID`, `tag:ID`, `note:ID`, or nowhere any more */
export function lead(to) {
  if (to === null || !state.where) remember(TARGET, null);
  else remember(TARGET, { mission: state.where.mission_id, to, whole_m: 0 });
  state.trouble = "";
  answer();
  const goal = target();
  if (goal && state.route) remember(TARGET, { ...goal, whole_m: state.route.distance_m });
  changed();
  scrollTo(0, 0);
}

/**
 * A tag was read, by whatever means.
 * @param {string} tagId
 * @param {string | null} [mission] the one it is of, where the link says so
 * @param {boolean} [isBack] the page's own history led here
 * @param {import("./told.js").Told | null} [told] what the server has said of it already
 * @param {number | null} [read_s] when the phone read the tag itself, by its clock; null where somebody chose it on the page
 */
export async function touch(tagId, mission = null, isBack = false, told = null, read_s = null) {
  if (read_s !== null && tagId === state.tagId && state.where) return touchedAgain(read_s);
  const known = lastTag();
  const isShownAgain = isBack && read_s === null; // a page loaded again, restored or gone back to: nobody touched anything
  const since_s = isShownAgain && known?.tag === tagId ? known.since_s : read_s ?? Date.now() / 1000;
  const isNews = !isShownAgain || (known?.tag === tagId && known.isTold === false);
  const before = known && known.tag !== tagId ? known.tag : known?.before ?? "";
  const address = tagId ? `/t/${encodeURIComponent(tagId)}${mission ? `?mission=${encodeURIComponent(mission)}` : ""}` : "/phone";
  if (!isBack && location.pathname + location.search !== address) history.pushState(null, "", address);
  wanted = mission;
  Object.assign(state, { tagId, before, where: null, route: null, said: "", trouble: "", form: "", scanning: false, foreign: null, choices: [], odd: null, elsewhere: "" });
  if (!tagId) return changed();
  const own = known && Date.now() / 1000 - known.since_s < SHIFT_S ? known.mission : "";
  const last = { tag: tagId, before, since_s, mission: own, isTold: !isNews };
  remember(LAST, last);
  answer();
  if (!state.where && told) Object.assign(state, { where: told.where, as_of_s: told.as_of_s });
  if (state.where) remember(LAST, { ...last, mission: missionId() });
  const came = read_s === null ? {} : judge(read_s);
  begin();
  changed();
  if (!state.where) await askServer();
  else if (reach.inReach !== false) await renew();
  const mission_id = missionId();
  if (state.tagId !== tagId || !state.where) return;
  if (lastTag()?.tag === tagId) remember(LAST, { ...lastTag(), mission: mission_id });
  if (!isShownAgain && own && own !== mission_id && !isOver(own)) changed({ elsewhere: keptOf(own)?.mission_name ?? own });
  if (isNews) add("at", mission_id, { tag_id: tagId, ...came }, since_s).then(() => remember(LAST, { ...remembered(LAST), isTold: true }));
  const { askMemory } = await import("./memory_view.js");
  askMemory(mission_id, tagId);
}

/** The tag one is at was touched once more: one is at it, however far the phone's steps have gone. @param {number} read_s */
function touchedAgain(read_s) {
  const came = judge(read_s);
  begin();
  remember(LAST, { ...remembered(LAST), tag: state.tagId, since_s: read_s, isTold: true });
  add("at", missionId(), { tag_id: state.tagId, ...came }, read_s);
  changed();
}

/**
 * See whether the phone can have come here from where it was.
 * @param {number} read_s
 * @returns {{from_tag?: string, after_s?: number, steps_m?: number}} from where it came, for the server
 */
function judge(read_s) {
  const { mission_id } = state.where ?? {};
  if (!mission_id) return {};
  const now = { mission: mission_id, tag: state.tagId, phone_s: read_s, offset_s: reach.offset_s };
  const earlier = remembered(SEEN) ?? [];
  const { odd, seen } = judged(earlier, now);
  state.odd = odd;
  remember(SEEN, seen);
  if (odd) return { from_tag: odd.before, after_s: odd.after_s };
  const came = cameFrom(earlier, now);
  const steps_m = came && walkedFrom(came.from_tag);
  return { ...came, ...(steps_m === null ? {} : { steps_m }) };
}

/** @type {string | null} */
let wanted = null;

/** Answer from what the phone carries. */
export function answer() {
  const item = missionOf(state.tagId, wanted, lastTag()?.mission ?? "") ?? (state.tagId ? null : missions()[0]);
  if (!item) return;
  const pocket = pocketOf(item);
  state.as_of_s = item.as_of_s;
  if (pocket !== state.pocket || ownNotes(pocket) !== own) {
    own = ownNotes(pocket);
    state.pocket = pocket;
    state.roads = new Roads(pocket, notesWith(pocket));
    takeOrder(pocket.mission_id, pocket.evacuation);
  }
  if (!state.roads) return;
  state.where = whereIs(pocket, state.roads, state.tagId);
  const goal = target();
  state.route = goal ? routeTo(pocket, state.roads, state.tagId, goal.to) : null;
  if (goal && !state.route) state.trouble = say("no_way_there");
  else if (state.trouble === say("no_way_there")) state.trouble = "";
}

let own = "";

/** This phone's notes that its copy of the mission lacks, whether the server has them or not. @param {Pocket} pocket */
function lacking(pocket) {
  const known = new Set(pocket.notes.map(({ annotation_id }) => annotation_id));
  const mine = waiting().filter(({ id, kind, mission_id }) => kind === "note" && mission_id === pocket.mission_id && !known.has(id));
  return new Map([...sentBeyond(pocket, keptOf(pocket.mission_id)?.as_of_s ?? 0), ...mine].map((report) => [report.id, report]));
}

/** Their names: with others, roads are others. @param {Pocket} pocket */
const ownNotes = (pocket) => [...lacking(pocket).keys()].sort().join();

/** Notes with those of this phone that are not among them yet. @param {Pocket} pocket @returns {PocketNote[]} */
function notesWith(pocket) {
  const places = new Map(pocket.tags.map(({ tag_id, x_m, y_m }) => [tag_id, { x_m, y_m }]));
  return [...pocket.notes, ...[...lacking(pocket).values()].map(({ id, body, made_by, phone_unix_s }) => ({
    annotation_id: id, kind: body.note, text: body.text, tag_id: body.tag_id, x_m: null, y_m: null, area_m: [], by: made_by,
    changed_unix_s: phone_unix_s, ends: [], ...places.get(body.tag_id),
  }))];
}

/** The phone does not know this tag: the server may. */
async function askServer() {
  const own = lastTag()?.mission;
  const found = (!wanted && own && !isOver(own) && (await whereBy(own))) || (await whereBy(wanted));
  if (found && found.tag_id === state.tagId) {
    changed({ where: found, as_of_s: null });
    await refresh(found.mission_id);
    return answerAnew();
  }
  changed({ trouble: say(whyUnknown(), { tag: state.tagId, mission: wanted ?? "" }) });
}

/** What the server says of the tag. @param {string | null} mission only of this one */
function whereBy(mission) {
  const query = new URLSearchParams({ language: language(), ...(mission ? { mission } : {}) });
  return read(`/where/${encodeURIComponent(state.tagId)}?${query}`);
}

/** @returns {import("./texts.js").Key} */
function whyUnknown() {
  if (!IS_TAG.test(state.tagId)) return "link_damaged";
  if (reach.isLoggedOut) return "log_in_to_see";
  if (reach.inReach) return wanted ? "tag_not_in_mission" : "tag_unknown";
  return missions().length ? "tag_unknown_here" : "nothing_here";
}

/** Get the newest of the mission that is shown. */
async function renew() {
  const mission = state.where?.mission_id;
  if (!mission) return;
  await opened;
  if (!state.roads) answerAnew(); // all that was there is what the server had said
  const found = await refresh(mission);
  if (found !== "failed") state.as_of_s = keptOf(mission)?.as_of_s ?? state.as_of_s;
  if (found === "new" || (state.pocket && ownNotes(state.pocket) !== own)) state.roads ? answer() : answerAnew();
  changed();
}

/** Answer where the mission was not on the phone before: steps count from this tag on. */
function answerAnew() {
  answer();
  begin();
  changed();
}

/** Go on getting the newest while the page is in sight. */
export async function keepFresh() {
  if (document.visibilityState === "visible") {
    if (state.where) await renew();
    else await refreshAll();
    if (!state.where) {
      answer();
      if (state.where) state.trouble = "";
    }
    changed();
  }
  setTimeout(keepFresh, FRESH_MS);
}

onOutbox(() => {
  if (state.pocket && ownNotes(state.pocket) !== own) answer();
  changed();
});
