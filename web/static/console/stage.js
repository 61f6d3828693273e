/** What lies over the plan: tools, layers, scale, cursor, north, and words when there is nothing to show. */

import { northOf, toEarth, toMgrs } from "./earth.js";
import { fixed } from "./format.js";
import { GeoreferencePanel } from "./georeference.js";
import { GroundKey } from "./ground.js";
import { gridReference } from "./grid_reference.js";
import { BestWords, MapSwitch } from "./map_switch.js";
import { MeasureTool } from "./measure.js";
import { NoteCard, NoteTool } from "./notes.js";
import { Search } from "./search.js";
import { SectorPanel, SectorTool } from "./sectors.js";
import { LAYERS } from "./store.js";
import { Component, html } from "./vendor.js";

/** @import {Plan} from "./plan.js" */
/** @import {Selected, Store} from "./store.js" */

const LONGEST_BAR_PX = 120;

/** @param {{store: Store, plan: Plan, onSelect: (selected: Selected) => void}} props */
export function PlanTools({ store, plan, onSelect }) {
  const hasRobot = store.selected?.kind === "robot" && !store.best.isShown;
  return html`
    <${ToolRow} store=${store} onSelect=${onSelect} />
    <div class="tools tools-right">
      <${North} frame=${store.georeference} />
      <div class="tool-group" role="group" aria-label="Zoom">
        <button type="button" onClick=${() => plan.zoom(1)} aria-label="Zoom in" title="Zoom in (+)">+</button>
        <button type="button" onClick=${() => plan.zoom(-1)} aria-label="Zoom out" title="Zoom out (-)">−</button>
      </div>
      <button type="button" class="tool" aria-pressed=${plan.mode === "fit"} onClick=${() => plan.fit()}
              title="Show the whole mission (F)">Fit</button>
      ${hasRobot && html`<button type="button" class="tool" aria-pressed=${plan.mode === "follow"}
              onClick=${() => plan.follow()} title="Keep the selected robot in the middle (G)">Follow</button>`}
    </div>
    <${GroundKey} layers=${plan.layers} store=${store} />
    <div class="readout">
      <${ScaleBar} scale=${plan.scale()} />
      <${Coordinates} at=${plan.cursor ?? plan.middle()} tag=${plan.cursor?.tag} frame=${store.georeference} />
      ${noticeAt(plan, store) && html`<span class="tag-notice">${noticeAt(plan, store)}</span>`}
    </div>
    <${BestWords} store=${store} />
    <${NoteCard} store=${store} />
    <${GeoreferencePanel} store=${store} />
    <${SectorPanel} store=${store} />
    ${!store.placing && !store.sectorPanel && html`<${PlanWords} store=${store} />`}`;
}

/** @typedef {import("./earth.js").Georeference | null} Frame */

/** The tools in a row; on a phone behind one button. @extends {Component<{store: Store, onSelect: (selected: Selected) => void}, {isOpen: boolean}>} */
class ToolRow extends Component {
  /** @param {{store: Store, onSelect: (selected: Selected) => void}} props */
  render({ store, onSelect }) {
    const isOpen = this.state.isOpen ?? false;
    return html`<div class=${`tools tools-left ${isOpen ? "open" : ""}`}>
      <button type="button" class="tool tools-more" aria-expanded=${isOpen} onClick=${() => this.setState({ isOpen: !isOpen })}>Map tools</button>
      <${Search} store=${store} onSelect=${onSelect} />
      <${MapSwitch} store=${store} />
      <${LayerMenu} store=${store} />
      <${NoteTool} store=${store} />
      <${MeasureTool} store=${store} />
      <${SectorTool} store=${store} />
    </div>`;
  }
}

/** Where north is: to the right until somebody has said where the mission lies. @param {{frame: Frame}} props */
function North({ frame }) {
  const turn = northOf(frame);
  const [x, y] = [24 + 12 * Math.sin((turn * Math.PI) / 180), 24.5 - 12 * Math.cos((turn * Math.PI) / 180)];
  const where = frame ? `North is ${Math.round(turn)} degrees clockwise from up` : "North is to the right";
  return html`<svg class="north" viewBox="0 0 48 48" role="img" aria-label=${where}>
    <circle cx="24" cy="24" r="22" /><path class="needle" d="M28 24 10 17 14 24 10 31Z" transform=${`rotate(${turn - 90} 24 24)`} />
    <text x=${x} y=${y}>N</text></svg>`;
}

/**
 * Where the cursor is; without one, the middle of the plan.
 * @param {{at: {x_m: number, y_m: number}, tag?: string, frame: Frame}} props
 */
function Coordinates({ at, tag, frame }) {
  const [lat, lon] = frame ? toEarth(frame, at.x_m, at.y_m) : [0, 0];
  return html`<span class="cursor"><b>${gridReference(at.x_m, at.y_m)}</b>
  x ${fixed(at.x_m, 2)}  y ${fixed(at.y_m, 2)} m ${tag && html`<b>${tag}</b>`}${
    frame && html`<br/>${lat.toFixed(6)}, ${lon.toFixed(6)}  <b>${toMgrs(lat, lon)}</b>`}</span>`;
}

/**
 * What is wrong with the tag under the cursor, if anything.
 *
 * @param {Plan} plan
 * @param {Store} store
 */
function noticeAt(plan, store) {
  return (plan.cursor?.tag && store.tags.get(plan.cursor.tag)?.notice) || "";
}

/** A bar of 1, 2 or 5 times a power of ten metres. @param {{scale: number}} props */
function ScaleBar({ scale }) {
  const longest_m = LONGEST_BAR_PX / scale;
  const power = 10 ** Math.floor(Math.log10(longest_m));
  const length_m = ([5, 2, 1].find((factor) => factor * power <= longest_m) ?? 1) * power;
  const words = length_m < 1 ? `${Math.round(100 * length_m)} cm` : `${length_m} m`;
  return html`<span class="scale" role="img" aria-label=${`Scale: this bar is ${words} long`}>
    <i style=${{ width: `${length_m * scale}px` }}></i>${words}</span>`;
}

/** @extends {Component<{store: Store}, {isOpen: boolean}>} */
class LayerMenu extends Component {
  /** @param {{store: Store}} props */
  render({ store }) {
    const isOpen = this.state.isOpen ?? false;
    return html`
      <button type="button" class="tool" aria-expanded=${isOpen} aria-controls="layer-menu"
              onClick=${() => this.setState({ isOpen: !isOpen })}>Layers</button>
      ${isOpen && html`<fieldset class="layer-menu" id="layer-menu"
          onKeyDown=${(/** @type {KeyboardEvent} */ event) => event.key === "Escape" && this.setState({ isOpen: false })}>
        <legend class="unseen">Layers of the plan</legend>
        ${Object.entries(LAYERS).map(([name, [label]]) => html`
          <label><input type="checkbox" name=${name} checked=${store.layers[name]} onChange=${() => {
            store.layers[name] = !store.layers[name];
            store.keepPreferences();
          }} /><span>${label}</span></label>`)}
      </fieldset>`}`;
  }
}

/** Says what is going on while the plan has nothing to show. @param {{store: Store}} props */
function PlanWords({ store }) {
  const { state, reason } = store.connection;
  if (state === "none") {
    return html`<${Words} title="No mission yet">
      Run <code>make run</code> for a demonstration with four robots, or send in robots through the API.
      This page opens the mission as soon as it is there.<//>`;
  }
  if (state === "failed") {
    return html`<${Words} title="This mission cannot be shown">${reason} Choose another mission above.<//>`;
  }
  if (!store.mission) {
    return html`<${Words} title="Loading the mission" isBusy=${true}>${reason || "Asking the server for its state."}<//>`;
  }
  if (store.robots.size === 0) {
    const isPrepared = store.map || store.board.baseMap || store.sectors.size > 0 || store.annotations.size > 0;
    return isPrepared ? null : html`<${Words} title="Waiting for robots">
      The mission is open; no robot has been heard yet.<//>`;
  }
  if (!store.map && [...store.robots.values()].every((robot) => robot.heard_unix_s == null)) {
    return html`<${Words} title="Waiting for the first observation" isBusy=${true}>
      ${store.robots.size === 1 ? "One robot has" : `${store.robots.size} robots have`} joined and not yet reported.<//>`;
  }
  return null;
}

/** @param {{title: string, isBusy?: boolean, children?: unknown}} props */
function Words({ title, isBusy, children }) {
  return html`<div class="words" role="status">
    ${isBusy && html`<i class="busy" aria-hidden="true"></i>`}<strong>${title}</strong><p>${children}</p></div>`;
}
