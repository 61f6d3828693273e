/** What the phone shows, in one place, and who draws it again when it changes. */

/** @import {Roads} from "./roads.js" */
/** @import {Pocket, Route, Where} from "./types.js" */

export const state = {
  /** The tag that was read last. */ tagId: "",
  /** The tag before it, of the same mission. */ before: "",
  /** @type {Where | null} */ where: null,
  /** @type {Route | null} */ route: null,
  /** @type {Pocket | null} */ pocket: null,
  /** @type {Roads | null} */ roads: null,
  /** When the server said so, by its own clock. @type {number | null} */ as_of_s: null,
  trouble: "",
  /** @type {"" | "word" | "victim"} */ form: "",
  said: "",
  /** Compass heading of the phone, degrees from north; null where it tells none. @type {number | null} */ heading: null,
  /** What was read of the tag's memory. @type {(import("./memory.js").Said & {tagId: string, isFromChip: boolean}) | null} */ memory: null,
  /** Where the phone is by the nodes it hears. @type {(import("./locating.js").Located & {text: string}) | null} */ fix: null,
  /** The last MAYDAY called here that the server has: the mission, when by its clock, who has taken note. @type {{mission: string, at_s: number, noted_by: string} | null} */
  called: null,
  scanning: false,
  /** The mission of the tag before, by its name, where this one is of another. */ elsewhere: "",
  /** Why the tag that was read cannot be where the map has it. @type {import("./pace.js").TooFar | null} */ odd: null,
  /** What was left last, as it stands in a chip. @type {{tagId: string, text: string} | null} */ word: null,
  /** A tag's link of another server that was touched or scanned. @type {{tagId: string, host: string} | null} */ foreign: null,
  /** Tags that a typed number may mean. @type {string[]} */ choices: [],
};

/** @type {(() => void)[]} */
const drawers = [];

/** @param {() => void} draw called after every change */
export function onChange(draw) {
  drawers.push(draw);
}

/** @param {Partial<typeof state>} [change] */
export function changed(change = {}) {
  Object.assign(state, change);
  for (const draw of drawers) draw();
}

/** The mission this phone is in: that of the tag read last. */
export const missionId = () => state.where?.mission_id ?? state.pocket?.mission_id ?? "";
