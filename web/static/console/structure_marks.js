/** How safe a structure is, by FEMA's box, and that nobody alive is left in it, by INSARAG's rapid clearance. */

import { dayOf, hourOf, letters, linesOf, sizeThatFits, stroke } from "./sprayed.js";

/** @import {Clearance, Rating, Worksite} from "./types.js" */
/** @import {Marking} from "./sprayed.js" */

const STROKES = { low: 0, moderate: 1, high: 2 };
/** Where the safest entry is, as one faces the front: arrows beside a box at x. @type {Record<string, (x: number) => string>} */
export const ARROWS = {
  left: () => "M50 97H12M26 83 12 97 26 111",
  right: (x) => `M${x + 100} 97H${x + 138}M${x + 124} 83 ${x + 138} 97 ${x + 124} 111`,
  above: (x) => `M${x + 45} 44V8M${x + 31} 22 ${x + 45} 8 ${x + 59} 22`,
  below: (x) => `M${x + 45} 152V188M${x + 31} 174 ${x + 45} 188 ${x + 59} 174`,
};

/** AUS-01 as INSARAG's edition of 2020 draws it, AUS01 as that of 2027, other names as they are. @param {string} team @param {boolean} isNew */
export function teamName(team, isNew) {
  const found = /^([A-Z]{3})-?([0-9]{2})$/.exec(team);
  return found ? `${found[1]}${isNew ? "" : "-"}${found[2]}` : team;
}

/**
 * A box, empty, struck once or crossed out by the risk; an arrow to the safest entry; date, time, hazards and team.
 * @param {Worksite} worksite @param {Rating} rating the newest @returns {Marking}
 */
export function structureMarking(worksite, { team, risk, entry, rated_unix_s: when }) {
  const hazards = linesOf(worksite.hazards.toUpperCase(), 14).slice(0, 4);
  const lines = [dayOf(when), hourOf(when), ...hazards, team];
  const x = entry === "left" ? 60 : 12;
  const left = x + (entry === "right" ? 148 : 104);
  const crossing = [`M${x} 142 ${x + 90} 52`, `M${x} 52 ${x + 90} 142`].slice(0, STROKES[risk]);
  const paths = [`M${x} 52H${x + 90}V142H${x}Z`, ...crossing, ...(entry ? [ARROWS[entry](x)] : [])];
  return { name: "FEMA structure", words: `${team} rates the structure a ${risk} risk${entry ? `, safest entry ${entry}` : ""}`,
    width: 300, height: Math.max(entry === "below" ? 196 : 156, 62 + 22 * lines.length),
    shapes: [...paths.map((path) => stroke(path, 7)),
      ...lines.map((text, k) => letters(text, left, 72 + 22 * k, sizeThatFits(text, 20, 296 - left), "start"))] };
}

/** A diamond with C, clear, or D, deceased only; team and day below. @param {Clearance} clearance @param {boolean} isNew @returns {Marking} */
export function clearanceMarking({ team, found, cleared_unix_s }, isNew) {
  const isClear = found === "clear";
  const name = teamName(team, isNew);
  return { name: "Rapid clearance", words: `${team} has ${isClear ? "cleared it" : "left only deceased in it"}`, width: 100, height: 150,
    shapes: [stroke("M50 8 92 50 50 92 8 50Z", 6), letters(isClear ? "C" : "D", 50, 66, 46),
      letters(name, 50, 118, sizeThatFits(name, 18, 96)), letters(dayOf(cleared_unix_s), 50, 140, 18)] };
}
