/** Leaving word at a tag: what somebody else has to know. It is on the phone at once, and goes out when it can. */

import { NOTE_KINDS } from "../console/note_kinds.js";
import { html } from "../console/vendor.js";
import { IntoChip } from "./nfc_view.js";
import { add } from "./outbox.js";
import { smaller } from "./photo.js";
import { changed, missionId, state } from "./state.js";
import { say } from "./texts.js";
import { VictimForm } from "./victim_form.js";

/** @typedef {import("./texts.js").Key} Key */

/** @param {SubmitEvent} event */
async function leaveWord(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  const kind = /** @type {HTMLButtonElement} */ (event.submitter).value;
  const text = String(new FormData(form).get("text")).trim();
  if (kind === "victim") {
    changed({ form: "victim", said: "" });
    return;
  }
  await add("note", missionId(), { note: kind, text, tag_id: state.tagId });
  const word = { tagId: state.tagId, text: `${kind}: ${text}` };
  changed({ form: "", word, said: say("left_at", { kind: say(/** @type {Key} */ (`kind_${kind}`)), tag: state.tagId }), trouble: "" });
}

/** A photo is left as soon as it is taken. @param {Event} event */
async function leavePhoto(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const [file] = input.files ?? [];
  input.value = "";
  if (!file) return;
  const text = String(new FormData(/** @type {HTMLFormElement} */ (input.form)).get("text")).trim().slice(0, 500);
  await add("photo", missionId(), { tag_id: state.tagId, text, picture: await smaller(file) });
  changed({ form: "", said: say("left_at", { kind: say("kind_photo"), tag: state.tagId }), trouble: "" });
}

export function Word() {
  if (state.form === "victim") return html`<${VictimForm} />`;
  if (state.form !== "word") {
    return html`<${IntoChip} /><button type="button" onClick=${() => changed({ form: "word", said: "", word: null })}>${say("leave_word")}</button>`;
  }
  return html`<form onSubmit=${leaveWord}>
    <label>${say("what_is_here")}<input name="text" maxlength="2000" /></label>
    <div class="row">${Object.entries(NOTE_KINDS).map(([kind, { glyph }]) => html`<button type="submit" name="kind"
      value=${kind}>${glyph} ${say(/** @type {Key} */ (`kind_${kind}`))}</button>`)}
      <label class="button">◉ ${say("kind_photo")}<input class="unseen" type="file" accept="image/*" capture="environment"
        onChange=${leavePhoto} /></label></div></form>`;
}
