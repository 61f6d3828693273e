/** The language that is spoken: the one that was chosen on this phone, else the first of its own that there is. */

const CHOSEN = "waymark.language";
const KNOWN = ["en", "de"]; // as LANGUAGES in texts.js

/** The fact by which the page tells its worker what it speaks. */
export const SPOKEN = "language";
/** The page's, as its worker knows it, which has no localStorage. */
let pages = "";

/** @returns {string} */
export function language() {
  const chosen = globalThis.localStorage?.getItem(CHOSEN) ?? pages;
  const wanted = [chosen, ...navigator.languages].map((name) => name.slice(0, 2));
  return wanted.find((name) => KNOWN.includes(name)) ?? "en";
}

/** @param {string} name */
export function speak(name) {
  localStorage.setItem(CHOSEN, name);
  document.documentElement.lang = name;
}

/** In the worker: speak as the page does. @param {string} name */
export function speakAs(name) {
  pages = name;
}
