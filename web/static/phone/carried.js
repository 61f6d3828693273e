/** The missions that a phone carries: which one a tag belongs to. */

/** @import {Pocket} from "./types.js" */
/** `as_of_s`: when this was the latest, by the server's clock; `parts`: names of the large ones by their content.
 * @typedef {{mission_id: string, mission_name: string, state: string, created_unix_s: number, etag: string, parts?: Record<string, string>, text: string, as_of_s: number, tag_ids: string[]}} Kept */
/** @typedef {{state: string, created_unix_s: number}} Standing */

/** First the one that is most likely meant: running, then the latest. @param {Standing} a @param {Standing} b */
export const byLikelihood = (a, b) => Number(b.state === "running") - Number(a.state === "running") || b.created_unix_s - a.created_unix_s;

/** Those that have a tag, first the one that is most likely meant. @param {Kept[]} items @param {string} tagId @param {string | null} missionId only this one, if told */
export const missionsWith = (items, tagId, missionId) => items
  .filter((item) => item.tag_ids.includes(tagId) && (!missionId || item.mission_id === missionId)).sort(byLikelihood);

/** @type {{text: string, pocket: Pocket} | null} */
let parsed = null;

/** @param {Kept} item @returns {Pocket} the same object as long as the text is the same */
export function pocketOf(item) {
  if (parsed?.text !== item.text) isParsed(item.text, JSON.parse(item.text));
  return /** @type {{pocket: Pocket}} */ (parsed).pocket;
}

/** @param {string} text @param {Pocket} pocket what it says */
export function isParsed(text, pocket) {
  parsed = { text, pocket };
}
