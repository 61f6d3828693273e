/** What the phone says, in one place. `say("key", {values})`; a language is one table (texts_en.js has all keys). */

import { language } from "./language.js";
import { DE } from "./texts_de.js";
import { EN } from "./texts_en.js";

/** A sentence with {names} in it, or one for each plural category of the value `n`. @typedef {string | {one: string, other: string}} Text */
/** @typedef {keyof typeof EN} Key */
/** @typedef {Partial<Record<Key, Text>>} Table */

/** @type {Record<string, {name: string, texts: Table}>} */
export const LANGUAGES = { en: { name: "English", texts: EN }, de: { name: "Deutsch", texts: DE } };

/**
 * @param {Key} key
 * @param {Record<string, string | number>} [values]
 * @returns {string} the sentence in the phone's language; in English where that has none
 */
export function say(key, values = {}) {
  const name = language();
  const text = LANGUAGES[name].texts[key] ?? /** @type {Text} */ (EN[key]);
  const chosen = typeof text === "string" ? text
    : new Intl.PluralRules(name).select(Number(values.n)) === "one" ? text.one : text.other;
  return chosen.replace(/\{(\w+)\}/g, (whole, name) => String(values[name] ?? whole));
}
