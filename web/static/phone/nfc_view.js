/** What the page offers where the browser reads chips by itself, and what to do where it does not. */

import { html } from "../console/vendor.js";
import { hasNfc, isReading, readTouched, waitsFor, writeNext, writeNothing } from "./nfc.js";
import { state } from "./state.js";
import { say } from "./texts.js";

export function TouchTags() {
  if (!hasNfc()) return html`<p class="soft">${say("nfc_instead")}</p>`;
  return isReading() ? html`<p class="soft">${say("nfc_reading")}</p>`
    : html`<button type="button" onClick=${readTouched}>${say("nfc_read")}</button>`;
}

/** Offered once a word was left at this tag: the next robot or person has it there without any network. It may wait until the tag is touched. */
export function IntoChip() {
  const { word, tagId } = state;
  const waiting = waitsFor();
  if (waiting) {
    return html`<p role="status"><b>${say(waiting === tagId ? "nfc_hold_still" : "nfc_waits", { tag: waiting })}</b></p>
      <button type="button" onClick=${writeNothing}>${say("nfc_write_not")}</button>`;
  }
  if (!hasNfc() || !word || word.tagId !== tagId) return null;
  return html`<button type="button" onClick=${() => writeNext(word.text)}>${say("nfc_write")}</button>`;
}
