/** What the server wrote into this page of the tag that it was opened at: words that need no second request. */

import { language } from "./texts.js";

/** `as_of_s`: by the server's clock. @typedef {{language: string, as_of_s: number, where: import("./types.js").Where}} Told */

/**
 * @param {string} tagId
 * @returns {Told | null} null where the page came from this phone, was opened by somebody who may not know, or speaks otherwise
 */
export function toldOf(tagId) {
  const text = document.getElementById("told")?.textContent;
  /** @type {Told | null} */
  const told = text ? JSON.parse(text) : null;
  return told?.where.tag_id === tagId && told.language === language() ? told : null;
}
