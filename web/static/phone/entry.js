/** Saying which tag one is at, where the phone was not told by touch. */

import { html } from "../console/vendor.js";
import { state } from "./state.js";
import { say } from "./texts.js";

export function Entry() {
  /** @param {SubmitEvent} event */
  const go = (event) => {
    event.preventDefault();
    const id = String(new FormData(/** @type {HTMLFormElement} */ (event.target)).get("id")).replace(/\s+/g, "");
    if (id) location.assign(`/t/${encodeURIComponent(id)}`);
  };
  return html`<h1>${say("which_tag")}</h1>
    ${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}
    <form onSubmit=${go}><label>${say("number_on_tag")}<input name="id" autocapitalize="characters" autocomplete="off"
      spellcheck="false" maxlength="100" required /></label><button type="submit">${say("where_am_i")}</button></form>`;
}
