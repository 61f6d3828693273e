/** Worksites as they are marked at their front: INSARAG, by the edition of their id, and FEMA. */

import { holds } from "./area.js";
import { dayOf, hourOf, letters, linesOf, sizeThatFits, stroke } from "./sprayed.js";
import { clearanceMarking, structureMarking, teamName } from "./structure_marks.js";

/** @import {Sector, Victim, Visit, Worksite} from "./types.js" */
/** @import {Marking, Shape} from "./sprayed.js" */
/** @typedef {{live: number, dead: number, uncounted: number}} Inside */

/** INSARAG's triage of worksites. @type {Record<string, string>} */
export const TRIAGE = {
  A: "live victims confirmed, under 12 hours of work",
  B: "live victims confirmed, over 12 hours of work",
  C: "live victims possible",
  D: "only deceased",
};

/** Who is still in a sector, by the victims on the map. @param {Sector} sector @param {Iterable<Victim>} victims @returns {Inside} */
export function inside(sector, victims) {
  const there = [...victims].filter(({ merged_into, status, x_m, y_m }) =>
    !merged_into && status !== "dismissed" && holds(sector.area_m, x_m, y_m));
  return {
    live: there.reduce((sum, { live }) => sum + (live ?? 0), 0),
    dead: there.reduce((sum, { dead }) => sum + (dead ?? 0), 0),
    uncounted: there.filter(({ live, dead, status }) => live === null && dead === null && status !== "extricated").length,
  };
}

/** None where a sector is no worksite. @param {Sector} sector @param {Iterable<Victim>} victims @returns {Marking[]} */
export function worksiteMarkings(sector, victims) {
  const { worksite } = sector;
  if (!worksite) return [];
  const rating = worksite.ratings?.at(-1);
  return [insarag(worksite), ...(worksite.visits.length ? [fema(worksite, inside(sector, victims))] : []),
    ...(rating ? [structureMarking(worksite, rating)] : []),
    ...(worksite.clearances ?? []).map((clearance) => clearanceMarking(clearance, isNewEdition(worksite)))];
}

/** Whether its id is one of INSARAG's edition of 2027. @param {Worksite} worksite */
const isNewEdition = ({ worksite_id }) => !worksite_id.slice(0, 2).includes("-");

/** A box with the id and a line for every level done; hazards above, triage below. @param {Worksite} worksite @returns {Marking} */
function insarag(worksite) {
  const { worksite_id: name, triage, visits, is_complete } = worksite;
  const isNew = isNewEdition(worksite);
  const hazards = linesOf(worksite.hazards.toUpperCase(), 22);
  const top = 10 + 24 * hazards.length;
  const shapes = hazards.map((text, k) => letters(text, 150, 22 + 24 * k, sizeThatFits(text, 20, 280)));
  const done = visits.filter(({ level, is_finished }) => level && is_finished).map((visit) => lineOf(visit, isNew));
  const high = Math.max(200, 118 + 26 * done.length);
  shapes.push(stroke(`M30 ${top}H270V${top + high}H30Z`, 6), letters(name, 150, top + 78, sizeThatFits(name, 80, 224)));
  done.forEach((text, k) => shapes.push(letters(text, 150, top + 118 + 26 * k, sizeThatFits(text, 20, 224))));
  if (is_complete) shapes.push(stroke(`M8 ${isNew ? top + 94 : top + Math.floor(high / 2)}H292`, 6));
  if (triage) shapes.push(letters(triage, 150, top + high + 50, 52));
  return { name: `INSARAG ${isNew ? "2027" : "2020"}, worksite`, words: worksiteWords(worksite), width: 300,
    height: top + high + (triage ? 62 : 10), shapes };
}

/** A level that is done. @param {Visit} visit @param {boolean} isNew */
function lineOf({ team, level, left_unix_s }, isNew) {
  return `${teamName(team, isNew)} ASR${level} ${dayOf(left_unix_s ?? 0)}`;
}

/** @param {Worksite} worksite */
function worksiteWords({ worksite_id, triage, is_complete }) {
  return [`Worksite ${worksite_id}`, ...(triage ? [`${triage}: ${TRIAGE[triage]}`] : []),
    is_complete ? "no more work needed" : "not complete"].join(", ");
}

/**
 * The search marking: one stroke while a team is inside, with a dot where it left unfinished, a second one once all is
 * searched; team and entry left, exit above, hazards right, who is left below.
 * @param {Worksite} worksite @param {Inside} there @returns {Marking}
 */
function fema({ visits, hazards }, there) {
  const visit = visits.find(({ left_unix_s }) => left_unix_s === null) ?? visits[visits.length - 1];
  const { team, entered_unix_s: entered, left_unix_s: left, is_finished, parts } = visit;
  const shapes = [stroke("M100 60 200 160", 8),
    ...[team, dayOf(entered), hourOf(entered)].map((text, k) => letters(text, 96, 96 + 22 * k, sizeThatFits(text, 18, 92), "end")),
    ...linesOf(hazards.toUpperCase(), 9).slice(0, 6).map((text, k) => letters(text, 204, 72 + 22 * k, sizeThatFits(text, 18, 92), "start"))];
  let height = 180;
  let words = `${team} is inside`;
  if (left !== null) {
    shapes.push(letters(`${dayOf(left)} ${hourOf(left)}`, 150, 44, 18));
    shapes.push(is_finished ? stroke("M200 60 100 160", 8) : { ring: [150, 110, 5], width: 10 });
    words = `${team} ${is_finished ? "has searched all" : "left before all was searched"}, ${leftWords(there)}`;
    if (!there.uncounted) {
      shapes.push(letters([there.live && `${there.live} LIVE`, there.dead && `${there.dead} DEAD`].filter(Boolean).join(" ") || "0", 150, 190, 20));
      height = 204;
    }
  }
  if (parts) {
    shapes.push(stroke(`M70 ${height}H230V${height + 36}H70Z`, 4), letters(parts, 150, height + 24, sizeThatFits(parts, 18, 150)));
    height += 46;
  }
  return { name: "FEMA search", words, width: 300, height, shapes };
}

/** @param {Inside} there */
function leftWords({ live, dead, uncounted }) {
  if (uncounted) return `victims not counted yet at ${uncounted} places`;
  const counts = [live && `${live} live`, dead && `${dead} dead`].filter(Boolean).join(" and ");
  return `${counts || "nobody"} still inside`;
}
