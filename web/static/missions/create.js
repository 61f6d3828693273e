/** A new mission: its name, whether it begins at once, and what lies under its map. */

import { fetchChecked, missionPath, request } from "../console/api.js";
import { html } from "../console/vendor.js";
import { act, announce, show, state } from "./missions.js";

/** @import {MissionRow} from "./types.js" */

const UPLOAD_MS = 60_000;
const DEFAULT_M = 0.05;
let base = "none";

/** @param {string} missionId @param {FormData} words */
async function layPlan(missionId, words) {
  const picture = /** @type {File} */ (words.get("picture"));
  const yaml = /** @type {File} */ (words.get("yaml"));
  /** @type {Record<string, string>} */
  const told = yaml?.size ? { yaml: await yaml.text() } : { resolution_m: String(words.get("resolution")) };
  await fetchChecked(`/api/v1${missionPath(missionId)}/base-map?${new URLSearchParams({ ...told, source: picture.name || "a floor plan" })}`, {
    method: "PUT", body: picture, headers: { "Content-Type": picture.type || "application/octet-stream" },
    signal: AbortSignal.timeout(UPLOAD_MS),
  });
}

/** @param {SubmitEvent} event */
function create(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  const words = new FormData(form);
  act("create", async () => {
    const mission = await request("POST", "/missions", {
      name: String(words.get("name")).trim(), state: words.get("draft") ? "draft" : "running",
    });
    try {
      if (base === "plan") await layPlan(mission.mission_id, words);
      else if (base !== "none") await request("POST", `${missionPath(mission.mission_id)}/base-map/copy`, { mission_id: base });
    } catch (error) {
      throw new Error(`${mission.name} was made, but without its base map. ${/** @type {Error} */ (error).message}`);
    }
    form.reset();
    base = "none";
    announce(`${mission.name} was made.`);
  });
}

/** @param {{missions: MissionRow[]}} props */
export function CreateForm({ missions }) {
  const mapped = missions.filter(({ explored_m2 }) => explored_m2 > 0);
  return html`<section aria-labelledby="create"><h2 id="create">${missions.length ? "A new mission" : "The first mission"}</h2>
    <form class="row" onSubmit=${create}>
      <label class="grow">Name<input name="name" required maxlength="200" placeholder="Collapsed school, north wing" pattern=".*\\S.*"/></label>
      <label>Under its map<select name="base" value=${base} onChange=${(/** @type {any} */ event) => {
        base = event.currentTarget.value;
        show();
      }}><option value="none">nothing</option><option value="plan">a floor plan</option>
        ${mapped.map(({ mission_id, name }) => html`<option value=${mission_id}>the map of ${name}</option>`)}</select></label>
      ${base === "plan" && html`
        <label>Picture (PNG, PGM, JPEG, WebP)<input type="file" name="picture" required accept=".png,.pgm,.jpg,.jpeg,.webp"/></label>
        <label>Its YAML, as of ROS's map_server<input type="file" name="yaml" accept=".yaml,.yml"/></label>
        <label>or metres per pixel<input name="resolution" type="number" min="0.001" max="10" step="any" defaultValue=${DEFAULT_M}/></label>`}
      <label class="check"><input type="checkbox" name="draft"/>As a draft: robots may join, and are refused until it is started</label>
      <button type="submit" disabled=${state.busy !== ""}>${state.busy === "create" ? "Working…" : "Make it"}</button></form></section>`;
}
