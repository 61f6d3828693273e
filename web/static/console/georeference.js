/** Saying where the mission lies on the Earth: by two points or more that are known on both, or by origin and heading. */

import { missionPath, request } from "./api.js";
import { placeTyped, toEarth, toMgrs } from "./earth.js";
import { fixed, timeOfDay } from "./format.js";
import { html } from "./vendor.js";

/** @import {Georeference} from "./earth.js" */
/** @import {Store} from "./store.js" */
/** @typedef {{x_m: number | null, y_m: number | null, typed: string}} Point */
/** @typedef {{by: "points" | "origin", points: Point[], origin: string, bearing: string, trouble: string, busy: boolean}} Placing */

const EXAMPLE = "48.13715, 11.57612 or 32U PU 91607 34903";
/** @returns {Point} */
const noPoint = () => ({ x_m: null, y_m: null, typed: "" });

/** @param {Store} store */
export function openGeoreference(store) {
  const points = (store.georeference?.points ?? []).map(([x_m, y_m, lat, lon]) => ({ x_m, y_m, typed: `${lat}, ${lon}` }));
  while (points.length < 2) points.push(/** @type {any} */ (noPoint()));
  store.placing = { by: "points", points, origin: "", bearing: "", trouble: "", busy: false };
  store.changed();
}

/** @param {Store} store */
function close(store) {
  store.placing = null;
  if (store.picking?.kind === "georeference") store.picking = null;
  store.changed();
}

/** @param {Store} store @param {Placing} placing @param {string} method @param {object} [body] */
async function send(store, placing, method, body) {
  Object.assign(placing, { trouble: "", busy: true });
  store.changed();
  try {
    await request(method, `${missionPath(store.missionId ?? "")}/georeference`, body);
    close(store);
  } catch (error) {
    Object.assign(placing, { trouble: /** @type {Error} */ (error).message, busy: false });
    store.changed();
  }
}

/** @param {Store} store @param {Placing} placing */
function keep(store, placing) {
  const points = placing.points.filter(({ x_m, typed }) => x_m !== null && typed.trim());
  const body = placing.by === "points"
    ? { control_points: points.map(({ x_m, y_m, typed }) => ({ x_m, y_m, ...placeTyped(typed) })) }
    : { origin: placeTyped(placing.origin), yaw_rad: ((90 - Number(placing.bearing)) * Math.PI) / 180 };
  return send(store, placing, "PUT", body);
}

/** Over the plan, while it is open. @param {{store: Store}} props */
export function GeoreferencePanel({ store }) {
  const { placing, georeference } = store;
  if (placing === null) return null;
  const isReady = placing.by === "points"
    ? placing.points.filter(({ x_m, typed }) => x_m !== null && typed.trim()).length >= 2
    : placing.origin.trim() !== "" && placing.bearing.trim() !== "" && Number.isFinite(Number(placing.bearing));
  /** @param {"points" | "origin"} by @param {string} label */
  const way = (by, label) => html`<button type="button" aria-pressed=${placing.by === by} onClick=${() => {
    placing.by = by;
    store.changed();
  }}>${label}</button>`;
  return html`<section class="tag-card georeference" aria-label="Where the mission lies on the Earth">
    <header><h3>Place on the Earth</h3>
      <button type="button" aria-label="Close" onClick=${() => close(store)}>×</button></header>
    <p class="hint-line">${georeference ? words(georeference) : "Nobody has said yet where this mission lies; the plan is drawn with north to the right."}</p>
    <div class="draft-kinds" role="group" aria-label="How">${way("points", "By known points")}${way("origin", "By origin and heading")}</div>
    ${placing.by === "points" ? html`<${PointRows} store=${store} placing=${placing} />` : html`
      <label>Origin of the plan (x 0, y 0)<input value=${placing.origin} placeholder=${EXAMPLE} maxlength="60"
        onInput=${(/** @type {any} */ event) => { placing.origin = event.currentTarget.value; store.changed(); }}/></label>
      <label>Compass bearing of the plan's right side, degrees<input value=${placing.bearing} inputmode="decimal" placeholder="90" maxlength="10"
        onInput=${(/** @type {any} */ event) => { placing.bearing = event.currentTarget.value; store.changed(); }}/></label>`}
    ${placing.trouble && html`<p class="warn" role="alert">${placing.trouble}</p>`}
    <div class="draft-kinds"><button type="button" disabled=${!isReady || placing.busy} onClick=${() => keep(store, placing)}>${
      placing.busy ? "Working…" : "Keep"}</button>
      ${georeference && html`<button type="button" disabled=${placing.busy} onClick=${() => send(store, placing, "DELETE")}>Forget</button>`}</div></section>`;
}

/** @param {{store: Store, placing: Placing}} props */
function PointRows({ store, placing }) {
  /** @param {Point} point @param {number} k */
  const pick = (point, k) => {
    const isAgain = store.picking?.kind === "georeference" && store.picking.id === String(k);
    store.picking = isAgain ? null : { id: String(k), kind: "georeference", then: (place) => {
      Object.assign(point, place);
      store.changed();
    } };
    store.changed();
  };
  return html`<ol class="points">${placing.points.map((point, k) => {
    const isPicking = store.picking?.kind === "georeference" && store.picking.id === String(k);
    return html`<li key=${k}><button type="button" aria-pressed=${isPicking} onClick=${() => pick(point, k)}>${isPicking ? "Click on the plan"
      : point.x_m === null ? `Point ${k + 1}: pick…` : `x ${fixed(point.x_m, 1)} y ${fixed(point.y_m, 1)}`}</button>
      <input aria-label=${`Point ${k + 1} on the Earth`} value=${point.typed} placeholder=${EXAMPLE} maxlength="60"
        onInput=${(/** @type {any} */ event) => { point.typed = event.currentTarget.value; store.changed(); }}/></li>`;
  })}</ol>
    <button type="button" class="quiet" onClick=${() => { placing.points.push(noPoint()); store.changed(); }}>One more point</button>`;
}

/** @param {Georeference & {changed_unix_s?: number}} frame */
function words(frame) {
  const [lat, lon] = toEarth(frame, 0, 0);
  const off = frame.points.length ? `; the points are ${fixed(frame.sd_m, 2)} m off on average` : "";
  return `The origin lies at ${lat.toFixed(6)}, ${lon.toFixed(6)} (${toMgrs(lat, lon) || "no grid here"})${off}. By ${frame.by} at ${timeOfDay(frame.changed_unix_s ?? 0)}.`;
}
