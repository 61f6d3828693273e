/** Saying which tag one is at, where the phone was not told by touch: by camera, or by the number on the label. */

import { html } from "../console/vendor.js";
import { goToScanned, goToTyped, leadToTyped } from "./meant.js";
import { TouchTags } from "./nfc_view.js";
import { Scan } from "./scan.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";
import { touch } from "./touch.js";

export function Entry() {
  /** @param {SubmitEvent} event */
  const go = (event) => {
    event.preventDefault();
    const typed = String(new FormData(/** @type {HTMLFormElement} */ (event.target)).get("id"));
    const { value } = /** @type {HTMLButtonElement} */ (event.submitter);
    value === "lead" ? leadToTyped(typed) : goToTyped(typed);
  };
  return html`<${TouchTags} />${state.scanning ? html`<${Scan} onText=${goToScanned} />`
    : html`<button type="button" onClick=${() => changed({ scanning: true, trouble: "" })}>${say("scan_label")}</button>`}
    <form onSubmit=${go}><label>${say("number_on_tag")}<input name="id" autocapitalize="characters" autocomplete="off"
      spellcheck="false" maxlength="100" required /></label><button type="submit">${say("where_am_i")}</button>
      ${state.roads && state.where && html`<button type="submit" value="lead">${say("lead_me_there")}</button>`}</form>`;
}

/** What has to be settled before a tag opens: a label of another server, or a number that several tags have. */
export function Doubt() {
  const { foreign, choices } = state;
  if (foreign) {
    const { host, tagId: tag } = foreign;
    return html`<div role="alert"><p class="trouble">${say("label_foreign", { host, tag })}</p>
      <div class="row"><button type="button" onClick=${() => touch(tag)}>${say("open_anyway", { tag })}</button>
      <button type="button" onClick=${() => changed({ foreign: null })}>${say("not_ours")}</button></div></div>`;
  }
  return choices.length > 0 && html`<div role="alert"><p>${say("which_of_them")}</p><div class="row">${choices.map((tagId) =>
    html`<button type="button" key=${tagId} onClick=${() => touch(tagId)}>${tagId}</button>`)}</div></div>`;
}
