/** What was written into this page of the tag that it was opened at, by the server or by the worker: words that need nothing else. */

import { here } from "./address.js";
import { language } from "./language.js";

/** @typedef {{title: string, text: string, warning: string}} Words */
/** `as_of_s`: by the server's clock. @typedef {{language: string, as_of_s: number, words: Words, where: import("./types.js").Where}} Told */

/** @returns {Told | null} null where there is nothing to say, or nothing for whoever asks, or it is said in another language */
function find() {
  const text = document.getElementById("told")?.textContent;
  /** @type {Told | null} */
  const found = text ? JSON.parse(text) : null;
  return found?.where.tag_id === here()[0] && found.language === language() ? found : null;
}

export const told = find();
