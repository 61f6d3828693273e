/** What was written into this page of the tag that it was opened at, by the server or by the worker: words that need nothing else. */

import { here } from "./address.js";
import { language } from "./language.js";

/** @typedef {{title: string, text: string, warning: string}} Words */
/** `as_of_s`: by the server's clock. @typedef {{language: string, as_of_s: number, words: Words, where: import("./types.js").Where}} Told */

/** The mission of the tag before, as touch.js remembers it. */
function lastMission() {
  try {
    return JSON.parse(localStorage.getItem("waymark.last") ?? "null")?.mission;
  } catch {
    return ""; // nothing can be read here
  }
}

/**
 * @returns {Told | null} null where there is nothing to say, or nothing for whoever asks, where it is said in another language, or of
 *   another mission than the one this phone is in, and no link named it
 */
function find() {
  const text = document.getElementById("told")?.textContent;
  /** @type {Told | null} */
  const found = text ? JSON.parse(text) : null;
  const [tagId, mission] = here();
  if (found?.where.tag_id !== tagId || found.language !== language()) return null;
  const { mission_id } = found.where;
  return [lastMission() || mission_id, mission].includes(mission_id) ? found : null;
}

export const told = find();
