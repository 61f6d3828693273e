/** What the phone says, in one place. `say("key", {values})`; a language is one table (texts_en.js has all keys). */

import { language } from "./language.js";
import { DE } from "./texts_de.js";
import { EN } from "./texts_en.js";

/** A sentence with {names} in it, or one for each plural category of the value `n`. @typedef {string | {one: string, other: string}} Text */
/** @typedef {keyof typeof EN} Key */
/** @typedef {Partial<Record<Key, Text>>} Table */

/** @type {Record<string, {name: string, texts: Table}>} */
export const LANGUAGES = { en: { name: "English", texts: EN }, de: { name: "Deutsch", texts: DE } };

const UNSEEN = /[\u0000-\u001f\u007f-\u009f]+/g;
const TURNS = /[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g; // text to be read from the other side, what follows it too
const HEAPED = /(\p{M}{2})\p{M}+/gu; // marks over marks cover the lines above

/** What others wrote, so that it can neither turn round nor cover what stands beside it. @param {string} text */
export const plain = (text) => text.replace(UNSEEN, " ").replace(TURNS, "").replace(HEAPED, "$1");

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
  return chosen.replace(/\{(\w+)\}/g, (whole, name) => plain(String(values[name] ?? whole)));
}
