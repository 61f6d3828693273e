/** Leaving word at a tag: what somebody else has to know. */

import { missionPath, request } from "../console/api.js";
import { newId, NOTE_KINDS } from "../console/notes.js";
import { html } from "../console/vendor.js";
import { wordsOf } from "./lead.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

/** @typedef {import("./texts.js").Key} Key */

let wordId = "";

/** @param {SubmitEvent} event */
async function leaveWord(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  const kind = /** @type {HTMLButtonElement} */ (event.submitter).value;
  const text = String(new FormData(form).get("text")).trim();
  const address = `${missionPath(state.where?.mission_id ?? "")}/annotations/${form.dataset.id}`;
  try {
    await request("PUT", address, { kind, text, tag_id: state.tagId });
    wordId = "";
    const said = say("left_at", { kind: say(/** @type {Key} */ (`kind_${kind}`)), tag: state.tagId });
    changed({ form: "", said, trouble: "" });
  } catch (error) {
    changed({ trouble: say("not_sent", { why: wordsOf(error) }) });
  }
}

export function Word() {
  if (state.form !== "word") {
    return html`<button type="button" onClick=${() => changed({ form: "word", said: "" })}>${say("leave_word")}</button>`;
  }
  wordId ||= newId();
  return html`<form onSubmit=${leaveWord} data-id=${wordId}>
    <label>${say("what_is_here")}<input name="text" maxlength="2000" /></label>
    <div class="row">${Object.entries(NOTE_KINDS).map(([kind, { glyph }]) => html`<button type="submit" name="kind"
      value=${kind}>${glyph} ${say(/** @type {Key} */ (`kind_${kind}`))}</button>`)}</div></form>`;
}
