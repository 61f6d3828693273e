/** A victim as it is marked with paint beside it: INSARAG (editions of 2020 and 2027 agree here) and FEMA. */

import { EM, lengthOf, letters, sizeThatFits, stroke } from "./sprayed.js";

/** @import {Victim} from "./types.js" */
/** @import {Marking, Shape} from "./sprayed.js" */

const LINE = 22; // from one count down to the next

/**
 * A dismissed one has none. Two of FEMA's once all are removed: its directive of 2014 draws an X over the marking,
 * cards of some task forces a vertical bar.
 * @param {Victim} victim
 * @returns {Marking[]}
 */
export function victimMarkings(victim) {
  if (victim.status === "dismissed") return [];
  const drawn = [insarag(victim), fema(victim, "FEMA", "M16 12 84 84M84 12 16 84")];
  if (isEmpty(victim)) drawn.push(fema(victim, "FEMA, by some cards", "M50 4V96"));
  return drawn;
}

/** What the markings say. @param {Victim} victim */
export function markingWords(victim) {
  const { live, dead, status } = victim;
  if (status === "dismissed") return "Nobody is there: no marking.";
  const left = [live ? `${live} live` : "", dead ? `${dead} dead` : ""].filter(Boolean).join(" and ");
  if (left) return `V, ${left} still there`;
  if (was(victim, "live") || was(victim, "dead")) return "V, all known victims removed";
  return status === "extricated" ? "V: say how many were there, so that they can be crossed out" : "V: a potential victim";
}

/** Counts that stood there before, the oldest first. @param {Victim} victim @param {"live" | "dead"} name */
const before = (victim, name) => victim[`${name}_before`] ?? [];

/** Whether such a victim was ever counted there. @param {Victim} victim @param {"live" | "dead"} name */
const was = (victim, name) => Boolean(victim[name]) || before(victim, name).length > 0;

/** Whether somebody was there and nobody is any more. @param {Victim} victim */
const isEmpty = (victim) => (was(victim, "live") || was(victim, "dead") || victim.status === "extricated")
  && !victim.live && !victim.dead;

/** A V, below it L-n and D-n; counts that hold no more are crossed out, the new one is below. @param {Victim} victim @returns {Marking} */
function insarag(victim) {
  const columns = /** @type {const} */ ([["L", "live"], ["D", "dead"]]).map(([letter, name]) => [
    ...before(victim, name).map((count) => ({ text: `${letter}-${count}`, isCrossed: true })),
    ...(victim[name] ? [{ text: `${letter}-${victim[name]}`, isCrossed: false }] : []),
  ]).filter((column) => column.length);
  const [places, room] = columns.length === 1 ? [[50], 92] : [[24, 76], 44];
  const rows = Math.max(0, ...columns.map((column) => column.length));
  return { name: "INSARAG 2020, 2027", words: markingWords(victim), width: 100, height: Math.max(100, 82 + LINE * rows),
    shapes: [stroke("M26 8 50 60 74 8", 9), ...columns.flatMap((column, k) => columnAt(column, places[k], room))] };
}

/** @param {{text: string, isCrossed: boolean}[]} column @param {number} x @param {number} room @returns {Shape[]} */
function columnAt(column, x, room) {
  return column.flatMap(({ text, isCrossed }, k) => {
    const y = 94 + LINE * k;
    const size = sizeThatFits(text, 19, room);
    const half = Math.floor((EM * size * lengthOf(text)) / 2);
    return [letters(text, x, y, size), ...(isCrossed ? [stroke(`M${x - half} ${y - Math.floor(size / 3)}H${x + half}`, 4)] : [])];
  });
}

/** A V; in a circle: alive when found; with a bar: dead when found; struck out: all were removed.
 * @param {Victim} victim @param {string} name @param {string} removed @returns {Marking} */
function fema(victim, name, removed) {
  /** @type {Shape[]} */
  const shapes = [stroke("M28 22 50 74 72 22", 9)];
  if (was(victim, "live")) shapes.push({ ring: [50, 46, 42], width: 6 });
  if (was(victim, "dead")) shapes.push(stroke("M14 46H86", 7));
  if (isEmpty(victim)) shapes.push(stroke(removed, 6));
  return { name, words: markingWords(victim), width: 100, height: 100, shapes };
}
