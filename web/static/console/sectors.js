/** Sectors: who searches which part of the ground, how far they are, and in which operational period. */

import { color } from "../theme.js";
import { missionPath, request } from "./api.js";
import { holds } from "./area.js";
import { newId } from "./note_kinds.js";
import { Periods } from "./periods.js";
import { html } from "./vendor.js";
import { WorksiteForm } from "./worksite.js";

/** @import {Sector, Worksite} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @import {Draft} from "./notes.js" */
/** @import {View} from "./canvas_layer.js" */

/** Status -> its name, its sign and its colour. @type {Record<string, [string, string, string]>} */
const STATUSES = {
  unassigned: ["Nobody is on it", "○", "text-soft"],
  under_way: ["Under way", "▶", "accent"],
  searched: ["Searched", "✓", "good"],
  second_look: ["Needs a second look", "↻", "warn"],
};
const SMALLEST_NAME_PX = 46;

/** @param {Store} store @param {string | null} id the sector that is open, null for the list of all */
export function openSector(store, id) {
  store.sectorPanel = { id, trouble: "" };
  store.changed();
}

/** @param {Store} store */
function close(store) {
  store.sectorPanel = null;
  if (store.draft?.kind === "sector") store.draft = null;
  store.changed();
}

/** @param {Store} store @param {() => Promise<unknown>} work @returns {Promise<boolean>} */
async function tried(store, work) {
  try {
    await work();
    if (store.sectorPanel) store.sectorPanel.trouble = "";
    return true;
  } catch (error) {
    if (store.sectorPanel) store.sectorPanel.trouble = /** @type {Error} */ (error).message;
    else store.notify(`The sector was not changed. ${/** @type {Error} */ (error).message}`);
    return false;
  } finally {
    store.changed();
  }
}

/** @param {Store} store @param {string} id */
const path = (store, id) => `${missionPath(store.missionId ?? "")}/sectors/${id}`;

/** Whoever is put on a free sector is under way there; one that nobody is on any more is free. @param {Sector} sector */
function fitting({ status, robots, team }) {
  const isTaken = robots.length > 0 || team !== "";
  if (isTaken && status === "unassigned") return "under_way";
  return !isTaken && status === "under_way" ? "unassigned" : status;
}

/** @param {Store} store @param {Sector} sector @param {Partial<Sector>} changes */
function change(store, sector, changes) {
  const { name, area_m, robots, team, note, status } = { ...sector, ...changes };
  const body = { name, area_m, robots, team, note, status: "status" in changes ? status : fitting({ ...sector, ...changes }),
    ...(changes.worksite ? { worksite: changes.worksite } : {}) };
  return tried(store, () => request("PUT", path(store, sector.sector_id), body));
}

/** Make a sector of corners and open it. @param {Store} store @param {string} name @param {[number, number][]} area_m */
export async function makeSector(store, name, area_m) {
  const id = newId();
  store.sectorPanel ??= { id: null, trouble: "" };
  if (await tried(store, () => request("PUT", path(store, id), { name: name.trim().slice(0, 60) || nextName(store), area_m }))) {
    store.draft = null;
    openSector(store, id);
  }
}

/** The first letter that no sector has yet. @param {Store} store */
function nextName(store) {
  const taken = new Set([...store.sectors.values()].map(({ name }) => name));
  return [..."ABCDEFGHIJKLMNOPQRSTUVWXYZ"].find((name) => !taken.has(name)) ?? `S${store.sectors.size + 1}`;
}

/** @param {{store: Store}} props */
export function SectorTool({ store }) {
  return html`<button type="button" class="tool" aria-expanded=${store.sectorPanel !== null} disabled=${!store.mission}
    onClick=${() => (store.sectorPanel ? close(store) : openSector(store, null))}>Sectors</button>`;
}

/** @param {{store: Store}} props */
export function SectorPanel({ store }) {
  const panel = store.sectorPanel;
  if (panel === null) return null;
  const sector = panel.id === null ? undefined : store.sectors.get(panel.id);
  if (store.draft?.kind === "sector") return html`<${Drawing} store=${store} draft=${store.draft} trouble=${panel.trouble} />`;
  return html`<section class="tag-card sectors" aria-label=${sector ? `Sector ${sector.name}` : "Sectors"}>
    <header><h3>${sector ? `Sector ${sector.name}` : "Sectors"}</h3>
      <button type="button" aria-label="Close the sectors" onClick=${() => close(store)}>×</button></header>
    ${panel.trouble && html`<p class="warn" role="alert">${panel.trouble}</p>`}
    ${sector ? html`<${SectorForm} key=${sector.sector_id} store=${store} sector=${sector} />`
      : html`<${Periods} store=${store} /><${SectorList} store=${store} />`}</section>`;
}

/** While corners are asked for: a strip that leaves the plan free. @param {{store: Store, draft: Draft, trouble: string}} props */
function Drawing({ store, draft, trouble }) {
  const leave = () => {
    store.draft = null;
    store.changed();
  };
  return html`<section class="sector-drawing" aria-label="Draw a sector">
    ${trouble && html`<p class="warn" role="alert">${trouble}</p>`}
    <p role="status">Click on its corners one after the other (${draft.corners.length} so far).</p>
    <label><span>Name</span><input maxlength="60" placeholder=${nextName(store)} value=${draft.text}
      onInput=${(/** @type {any} */ event) => (draft.text = event.currentTarget.value)} /></label>
    <button type="button" disabled=${draft.corners.length < 3} onClick=${() => makeSector(store, draft.text, draft.corners)}>Close the sector</button>
    <button type="button" disabled=${draft.corners.length === 0} onClick=${() => {
      draft.corners.pop();
      store.changed();
    }}>Last corner off</button>
    <button type="button" onClick=${leave}>Cancel</button></section>`;
}

/** @param {{store: Store}} props */
function SectorList({ store }) {
  const sectors = [...store.sectors.values()].sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
  const draw = () => {
    store.draft = { kind: "sector", text: "", isArea: true, corners: [] };
    store.picking = null;
    store.changed();
  };
  return html`${sectors.length === 0 && html`<p>No part of the ground is a sector yet. Draw one, then say who searches it.</p>`}
    <ul class="sector-list">${sectors.map((sector) => html`<li key=${sector.sector_id}><button type="button" onClick=${() => openSector(store, sector.sector_id)}>
      <b>${STATUSES[sector.status][1]} ${sector.name}</b><span>${STATUSES[sector.status][0]}${whoOf(sector) && `: ${whoOf(sector)}`}</span></button></li>`)}</ul>
    ${!store.isOver && store.may("operator") && html`<button type="button" onClick=${draw}>Draw a sector…</button>`}`;
}

/** @param {Sector} sector */
const whoOf = ({ robots, team }) => [...robots, ...(team ? [team] : [])].join(", ");

/** @param {{store: Store, sector: Sector}} props */
function SectorForm({ store, sector }) {
  const names = [...new Set([...store.robots.keys(), ...sector.robots])].sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
  /** @param {"name" | "team" | "note"} field @param {string} label @param {number} most */
  const text = (field, label, most) => html`<label>${label}<input key=${`${sector.sector_id} ${sector[field]}`} maxlength=${most}
    defaultValue=${sector[field]} onChange=${(/** @type {any} */ event) => change(store, sector, { [field]: event.currentTarget.value.trim() })}/></label>`;
  /** @param {string} name */
  const toggle = (name) => change(store, sector, {
    robots: sector.robots.includes(name) ? sector.robots.filter((other) => other !== name) : [...sector.robots, name] });
  const explore = () => tried(store, () => request("POST", `${path(store, sector.sector_id)}/explore`));
  const remove = async () => {
    if (await tried(store, () => request("DELETE", path(store, sector.sector_id)))) openSector(store, null);
  };
  return html`<fieldset disabled=${store.isOver || !store.may("operator")}>
    <p class="hint-line">${sector.size_m2} m²${sector.period !== null && `, operational period ${sector.period}`}. Changed by ${sector.by}.</p>
    <label>Status<select value=${sector.status} onChange=${(/** @type {any} */ event) => change(store, sector, { status: event.currentTarget.value })}>
      ${Object.entries(STATUSES).map(([value, [label]]) => html`<option value=${value} selected=${value === sector.status}
        disabled=${(value === "under_way" && !whoOf(sector)) || (value === "unassigned" && whoOf(sector) !== "")}>${label}</option>`)}</select></label>
    <div role="group" aria-label="Robots that search it" class="robot-ticks">${names.length === 0 ? html`<p>No robot has joined yet.</p>`
      : names.map((name) => html`<label key=${name}><input type="checkbox" checked=${sector.robots.includes(name)} onChange=${() => toggle(name)}/>${name}</label>`)}</div>
    ${text("team", "Team of people", 60)}${text("note", "Note", 2000)}${text("name", "Name", 60)}
    <div class="draft-kinds"><button type="button" disabled=${sector.robots.length === 0} onClick=${explore}
      title="Its robots drive there and look at what is unknown in it first">Send its robots there</button>
      <button type="button" onClick=${remove}>Remove</button></div>
    <${WorksiteForm} key=${sector.sector_id} store=${store} sector=${sector}
      onChange=${(/** @type {Worksite} */ worksite) => change(store, sector, { worksite })} /></fieldset>
    <button type="button" class="quiet" onClick=${() => openSector(store, null)}>All sectors</button>`;
}

/** The sector a point lies in, the smallest where several do. @param {Store} store @param {number} x @param {number} y */
export function sectorAt(store, x, y) {
  if (!store.layers.sectors) return undefined;
  return [...store.sectors.values()].filter(({ area_m }) => holds(area_m, x, y)).sort((a, b) => a.size_m2 - b.size_m2)[0];
}

/**
 * What a sector is called on the plan: at its topmost corner, inside it, where it is wide enough.
 * @param {Sector} sector @param {number} scale pixels a metre
 */
export function sectorName(sector, scale) {
  const [, sign, ink] = STATUSES[sector.status];
  const xs = sector.area_m.map(([x]) => x);
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const [x_m, y_m] = sector.area_m.reduce((best, corner) => (corner[1] > best[1] ? corner : best));
  const sides = x_m < (left + right) / 2 ? ["se", "sw", "s", "ne"] : ["sw", "se", "s", "nw"];
  const text = (right - left) * scale < SMALLEST_NAME_PX ? "" : `${sign} ${sector.name}${whoOf(sector) && ` · ${whoOf(sector)}`}`;
  return { x_m, y_m, sides, text, ink };
}

/** @param {Store} store */
export const drawSectors = (store) =>
  /** @param {CanvasRenderingContext2D} ctx @param {View} view */
  (ctx, view) => {
    if (!store.layers.sectors) return;
    for (const sector of store.sectors.values()) drawOne(ctx, view, sector, store.sectorPanel?.id === sector.sector_id);
  };

/** @param {CanvasRenderingContext2D} ctx @param {View} view @param {Sector} sector @param {boolean} isOpen */
function drawOne(ctx, view, sector, isOpen) {
  const [, , name] = STATUSES[sector.status];
  const at = sector.area_m.map(([x_m, y_m]) => [view.toX(x_m), view.toY(y_m)]);
  ctx.beginPath();
  at.forEach(([x, y], k) => (k ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
  ctx.closePath();
  ctx.fillStyle = ctx.strokeStyle = color(name);
  ctx.globalAlpha = isOpen ? 0.2 : 0.1;
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.lineWidth = isOpen ? 3.5 : 2;
  ctx.setLineDash(sector.status === "searched" ? [] : [10, 5]);
  ctx.stroke();
  ctx.setLineDash([]);
}
