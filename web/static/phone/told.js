/** What the server wrote into this page of the tag that it was opened at: words that need no second request. */

import { remembered } from "./reach.js";
import { language } from "./texts.js";

/** `as_of_s`: by the server's clock. @typedef {{language: string, as_of_s: number, where: import("./types.js").Where}} Told */

/**
 * @param {string} tagId
 * @returns {Told | null} null where the page came from this phone, was opened by somebody who may not know, speaks otherwise, or the
 *   server took another mission than the one this phone is in, and no link named it
 */
export function toldOf(tagId) {
  const text = document.getElementById("told")?.textContent;
  /** @type {Told | null} */
  const told = text ? JSON.parse(text) : null;
  const ours = [remembered("waymark.last")?.mission || told?.where.mission_id, new URL(location.href).searchParams.get("mission")];
  return told?.where.tag_id === tagId && told.language === language() && ours.includes(told.where.mission_id) ? told : null;
}
