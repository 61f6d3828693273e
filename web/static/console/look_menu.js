/** How the console looks and sounds here: theme and size, kept in this browser. */

import { chooseLook, chosenLook } from "../theme.js";
import { play } from "./sound.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */

const THEMES = [["auto", "As the device"], ["dark", "Dark"], ["daylight", "Daylight"]];
const SIZES = [["desk", "Desk"], ["wall", "Wall, read at 2 m"]];
const SOUNDS = [["off", "Off"], ["on", "For alerts, MAYDAY, EVACUATE"]];

/** What has opened from the bar closes by Escape and by a press elsewhere. */
export function closeMenus() {
  /** @param {Event} event */
  const close = (event) => {
    for (const menu of document.querySelectorAll("details.pop[open]")) {
      if (event instanceof KeyboardEvent ? event.key === "Escape" : !menu.contains(/** @type {Node} */ (event.target))) {
        menu.removeAttribute("open");
      }
    }
  };
  addEventListener("pointerdown", close);
  addEventListener("keydown", close);
}

/** @param {{store: Store}} props */
export function LookMenu({ store }) {
  const { theme, size, sound } = chosenLook();
  /** @param {object} chosen */
  const choose = (chosen) => {
    chooseLook(chosen);
    if ("sound" in chosen) play("warning"); // so that one hears that it is on
    store.changed();
  };
  return html`<details class="pop look">
    <summary aria-label="Look of this page" title="Look of this page: dark or daylight, desk or wall, sound">
      <svg viewBox="0 0 24 24" aria-hidden="true"><circle cx="12" cy="12" r="8" /><path d="M12 4a8 8 0 0 1 0 16Z" /></svg></summary>
    <div class="pop-card">
      <${Choice} name="theme" title="Theme" options=${THEMES} value=${theme} onChoose=${choose} />
      <${Choice} name="size" title="Size" options=${SIZES} value=${size} onChoose=${choose} />
      <${Choice} name="sound" title="Sound" options=${SOUNDS} value=${sound} onChoose=${choose} />
    </div></details>`;
}

/** @param {{name: string, title: string, options: string[][], value: string, onChoose: (chosen: object) => void}} props */
function Choice({ name, title, options, value, onChoose }) {
  return html`<fieldset class="choice"><legend>${title}</legend>${options.map(([option, label]) => html`
    <label><input type="radio" name=${name} value=${option} checked=${option === value}
      onChange=${() => onChoose({ [name]: option })} /><span>${label}</span></label>`)}</fieldset>`;
}
