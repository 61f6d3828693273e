/** Short cuts of the keyboard, in one list: what they do, and the sheet that tells. */

import { html } from "./vendor.js";

/** @typedef {{keys: string, words: string, act?: (key: string) => void}} ShortCut */

/**
 * Do what a pressed key stands for, unless somebody is writing or a sheet is open.
 * @param {KeyboardEvent} event
 * @param {ShortCut[]} shortCuts
 */
export function pressed(event, shortCuts) {
  const target = /** @type {HTMLElement} */ (event.target);
  if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
  if (document.querySelector("dialog[open]")) return;
  const found = shortCuts.find(({ keys, act }) => act && keys.split(" ").includes(event.key));
  if (!found?.act) return;
  event.preventDefault();
  found.act(event.key);
}

export function openHelp() {
  /** @type {HTMLDialogElement | null} */ (document.querySelector("#help"))?.showModal();
}

/** @param {{shortCuts: ShortCut[]}} props */
export function HelpSheet({ shortCuts }) {
  return html`<dialog id="help" aria-labelledby="help-title"><form method="dialog">
    <header><h2 id="help-title">Keys</h2><button aria-label="Close the sheet of keys">×</button></header>
    <dl>${shortCuts.map(({ keys, words }) => html`<div><dt>${keys.split(" ").map((key) => html`<kbd>${
      key.length === 1 ? key.toUpperCase() : key}</kbd> `)}</dt><dd>${words}</dd></div>`)}</dl>
    <p>STOP, EVACUATE and MAYDAY are held for half a second; with the keyboard hold Enter or Space.
      While a place is asked for, move the plan with the arrow keys and press Enter: the place is the middle of the plan.</p>
    </form></dialog>`;
}
