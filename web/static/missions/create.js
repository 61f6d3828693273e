/** A new mission: its name, and whether it begins at once. */

import { request } from "../console/api.js";
import { html } from "../console/vendor.js";
import { act, announce, state } from "./missions.js";

/** @import {MissionRow} from "./types.js" */

/** @param {SubmitEvent} event */
function create(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  const words = new FormData(form);
  act("create", async () => {
    const mission = await request("POST", "/missions", {
      name: String(words.get("name")).trim(), state: words.get("draft") ? "draft" : "running",
    });
    form.reset();
    announce(`${mission.name} was made.`);
  });
}

/** @param {{missions: MissionRow[]}} props */
export function CreateForm({ missions }) {
  return html`<section aria-labelledby="create"><h2 id="create">${missions.length ? "A new mission" : "The first mission"}</h2>
    <form class="row" onSubmit=${create}>
      <label class="grow">Name<input name="name" required maxlength="200" placeholder="Collapsed school, north wing" pattern=".*\\S.*"/></label>
      <label class="check"><input type="checkbox" name="draft"/>As a draft: robots wait until it is started</label>
      <button type="submit" disabled=${state.busy !== ""}>${state.busy === "create" ? "Working…" : "Make it"}</button></form></section>`;
}
