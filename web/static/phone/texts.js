/** What the phone says, in one place. `say("key", {values})`; a language is one table (texts_en.js has all keys). */

import { DE } from "./texts_de.js";
import { EN } from "./texts_en.js";

/** A sentence with {names} in it, or one for each plural category of the value `n`. @typedef {string | {one: string, other: string}} Text */
/** @typedef {keyof typeof EN} Key */
/** @typedef {Partial<Record<Key, Text>>} Table */

const CHOSEN = "waymark.language";
/** @type {Record<string, {name: string, texts: Table}>} */
export const LANGUAGES = { en: { name: "English", texts: EN }, de: { name: "Deutsch", texts: DE } };

/** @returns {string} the language that was chosen on this phone, else the first of its own that there is */
export function language() {
  const wanted = [localStorage.getItem(CHOSEN) ?? "", ...navigator.languages].map((name) => name.slice(0, 2));
  return wanted.find((name) => name in LANGUAGES) ?? "en";
}

/** @param {string} name */
export function speak(name) {
  localStorage.setItem(CHOSEN, name);
  document.documentElement.lang = name;
}

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
