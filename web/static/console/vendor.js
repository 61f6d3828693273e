/** The libraries, each imported at one place. Leaflet is a classic script and stands on the window. */
import { Component, h, render } from "/vendor/preact/preact.module.js";
import htm from "/vendor/htm/htm.module.js";

export const html = htm.bind(h);
export { Component, render };

/** @type {typeof import("leaflet")} */
export const L = /** @type {any} */ (globalThis).L;
