/**
 * Dark or daylight, how large, and with sounds or without: chosen once for all pages of this browser; until then as the device has it.
 *
 * Loaded before anything is painted, so that no page flashes up in the other theme.
 */

/** @typedef {"auto" | "dark" | "daylight"} Theme */
/** @typedef {"desk" | "wall"} Size */
/** @typedef {"off" | "on"} Sound */

/** @type {{theme: Theme, size: Size, sound: Sound}} */
const UNCHOSEN = { theme: "auto", size: "desk", sound: "off" };
const KEPT = "waymark.look";
const light = matchMedia("(prefers-color-scheme: light)");
/** @type {{theme: Theme, size: Size, sound: Sound}} */
const look = { ...UNCHOSEN, ...kept() };
/** Resolved colours of the theme, by name. @type {Map<string, string>} */
const colors = new Map();

function kept() {
  try {
    return JSON.parse(localStorage.getItem(KEPT) ?? "{}");
  } catch {
    return {}; // private browsing may forbid it
  }
}

function show() {
  const root = document.documentElement;
  root.dataset.theme = shownTheme();
  root.dataset.size = look.size;
  colors.clear();
  document.querySelector('meta[name="theme-color"]')?.setAttribute("content", color("ground"));
  dispatchEvent(new Event("look"));
}

/** @returns {"dark" | "daylight"} what is on the screen */
export function shownTheme() {
  return look.theme === "auto" ? (light.matches ? "daylight" : "dark") : look.theme;
}

export const chosenLook = () => ({ ...look });

/** @param {Partial<typeof UNCHOSEN>} chosen */
export function chooseLook(chosen) {
  Object.assign(look, chosen);
  try {
    localStorage.setItem(KEPT, JSON.stringify(look));
  } catch {
    // It holds until the page is closed.
  }
  show();
}

/** A colour of the palette as the theme on the screen has it, for what is drawn on a canvas. @param {string} name */
export function color(name) {
  let value = colors.get(name);
  if (value === undefined) {
    value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    if (value) colors.set(name, value);
  }
  return value;
}

/** Red, green and blue of a colour of the palette, 0..255. @param {string} name @returns {[number, number, number]} */
export function rgb(name) {
  const code = color(name);
  return [parseInt(code.slice(1, 3), 16), parseInt(code.slice(3, 5), 16), parseInt(code.slice(5, 7), 16)];
}

light.addEventListener("change", show);
addEventListener("storage", (event) => {
  if (event.key !== KEPT) return;
  Object.assign(look, UNCHOSEN, kept());
  show();
});
show();
