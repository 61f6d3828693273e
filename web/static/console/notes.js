/** What people write on the map: hazards, notes, searched ground, victims; at a point, at a tag, or over an area. */

import { color } from "../theme.js";
import { missionPath, request } from "./api.js";
import { timeOfDay } from "./format.js";
import { newId, NOTE_KINDS } from "./note_kinds.js";
import { Photos } from "./photos.js";
import { makeSector } from "./sectors.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */
/** @typedef {{kind: string, text: string, isArea: boolean, corners: [number, number][]}} Draft */

/** @param {Store} store @param {Draft} draft @param {object} place */
async function write(store, draft, place) {
  store.draft = null;
  store.changed();
  const id = newId();
  try {
    await request("PUT", `${missionPath(store.missionId ?? "")}/annotations/${id}`, { kind: draft.kind, text: draft.text.trim(), ...place });
  } catch (error) {
    store.draft = draft; // nothing of what was typed is lost
    store.notify(`Not written on the map. ${/** @type {Error} */ (error).message}`);
  }
}

/** A click on the plan while an area is being drawn. @param {Store} store @param {[number, number]} corner */
export function addCorner(store, corner) {
  if (!store.draft?.isArea) return false;
  store.draft.corners.push([Number(corner[0].toFixed(2)), Number(corner[1].toFixed(2))]);
  store.changed();
  return true;
}

/** @param {{store: Store}} props */
export function NoteTool({ store }) {
  const { draft } = store;
  const isMine = draft !== null && draft.kind !== "sector";
  const open = () => {
    store.draft = isMine ? null : { kind: "hazard", text: "", isArea: false, corners: [] };
    if (store.picking?.kind === "note") store.picking = null;
    store.changed();
  };
  return html`<button type="button" class="tool" aria-expanded=${isMine} disabled=${!store.mission || store.isOver}
      onClick=${open}>Note</button>
    ${isMine && html`<${DraftForm} store=${store} draft=${draft} />`}`;
}

/** @param {{store: Store, draft: Draft}} props */
function DraftForm({ store, draft }) {
  const tag = store.selected?.kind === "tag" ? store.selected.id : null;
  const isPicking = store.picking?.kind === "note";
  const onPlan = () => {
    draft.isArea = false;
    store.picking = isPicking ? null : { id: "", kind: "note", then: (place) => write(store, draft, place) };
    store.changed();
  };
  const asArea = () => {
    store.picking = null;
    Object.assign(draft, { isArea: !draft.isArea, corners: [] });
    store.changed();
  };
  return html`<div class="draft" role="group" aria-label="Write on the map">
    <div class="draft-kinds">${Object.entries(NOTE_KINDS).map(([kind, { label, glyph }]) => html`<button type="button"
      aria-pressed=${draft.kind === kind} onClick=${() => { draft.kind = kind; store.changed(); }}>${glyph} ${label}</button>`)}</div>
    <input aria-label="What it says" maxlength="2000" placeholder="What it says" value=${draft.text}
      onInput=${(/** @type {any} */ event) => (draft.text = event.currentTarget.value)} />
    <div class="draft-kinds">
      <button type="button" aria-pressed=${isPicking} onClick=${onPlan}>At a point…</button>
      <button type="button" aria-pressed=${draft.isArea} onClick=${asArea}>Over an area…</button>
      ${tag && html`<button type="button" onClick=${() => write(store, draft, { tag_id: tag })}>At tag ${tag}</button>`}
    </div>
    ${isPicking && html`<p role="status">Click on the plan: that is where it is.</p>`}
    ${draft.isArea && html`<p role="status">Click on its corners one after the other (${draft.corners.length} so far).</p>
      <button type="button" disabled=${draft.corners.length < 3}
        onClick=${() => write(store, draft, { area_m: draft.corners })}>Close the area</button>`}</div>`;
}

/** What the selected note says, and taking it away. @param {{store: Store}} props */
export function NoteCard({ store }) {
  if (store.selected?.kind !== "note") return null;
  const { id } = store.selected;
  const note = store.annotations.get(id);
  if (!note) return null;
  const remove = async () => {
    try {
      await request("DELETE", `${missionPath(store.missionId ?? "")}/annotations/${id}`);
      store.select(null);
    } catch (error) {
      store.notify(`Not removed. ${/** @type {Error} */ (error).message}`);
    }
  };
  return html`<section class="tag-card" aria-label=${NOTE_KINDS[note.kind]?.label ?? note.kind}>
    <header><h3>${NOTE_KINDS[note.kind]?.label ?? note.kind}</h3>
      <button type="button" aria-label="Close" onClick=${() => store.select(null)}>×</button></header>
    ${note.text && html`<p>${note.text}</p>`}
    <p class="hint-line">By ${note.by} at ${timeOfDay(note.changed_unix_s)}${note.tag_id && `, at tag ${note.tag_id}`}.</p>
    <${Photos} store=${store} of=${{ annotation_id: id }} />
    ${!store.isOver && html`<div class="draft-kinds"><button type="button" onClick=${remove}>Remove</button>
      ${note.area_m.length > 0 && store.may("operator") && html`<button type="button"
        onClick=${() => makeSector(store, note.text, note.area_m)}>Make it a sector</button>`}</div>`}</section>`;
}

/**
 * Areas, and the one that is being drawn.
 * @param {CanvasRenderingContext2D} ctx
 * @param {View} view
 * @param {Store} store
 */
export function drawAreas(ctx, view, store) {
  const drawn = [...store.annotations.values()].map(({ kind, area_m }) => ({ kind, corners: area_m }));
  if (store.draft?.isArea) drawn.push(store.draft);
  for (const { kind, corners } of drawn) {
    if (!corners.length) continue;
    ctx.fillStyle = ctx.strokeStyle = color((NOTE_KINDS[kind] ?? NOTE_KINDS.note).color);
    ctx.beginPath();
    corners.forEach(([x_m, y_m], k) => ctx[k ? "lineTo" : "moveTo"](view.toX(x_m), view.toY(y_m)));
    ctx.closePath();
    ctx.globalAlpha = 0.16;
    ctx.fill();
    ctx.globalAlpha = 0.9;
    ctx.lineWidth = 1.5;
    ctx.setLineDash([6, 4]);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }
}
