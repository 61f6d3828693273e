/** A sector as a worksite: what is marked at its front, and who goes in and comes out. */

import { timeOfDay } from "./format.js";
import { Sprayed } from "./sprayed.js";
import { StructureForm } from "./structure_form.js";
import { Component, html } from "./vendor.js";
import { inside, TRIAGE, worksiteMarkings } from "./worksite_marks.js";

/** @import {Sector, Visit, Worksite} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @typedef {{store: Store, sector: Sector, onChange: (worksite: Worksite) => Promise<boolean>}} Props */

/** INSARAG's levels of assessment, search and rescue. */
const LEVELS = ["Wide area assessment", "Worksite triage", "Rapid search and rescue", "Full search and rescue",
  "Total coverage, search and recovery"];
/** Ids of the editions of 2020 and 2027. */
const ID_PATTERN = "[A-Z]-[0-9]{1,4}[a-z]?|[A-Z]{3}[0-9]{2}-[0-9]{4}";

/** The next free id of the edition of 2020: the sector's letter and a number. @param {Store} store @param {Sector} sector */
function nextId(store, sector) {
  const letter = /^[a-z]/i.exec(sector.name)?.[0].toUpperCase() ?? "A";
  const taken = [...store.sectors.values()].map(({ worksite }) => worksite?.worksite_id ?? "");
  let number = 1;
  while (taken.includes(`${letter}-${number}`)) number += 1;
  return `${letter}-${number}`;
}

/** @extends {Component<Props, {team: string, level: string, parts: string}>} */
export class WorksiteForm extends Component {
  /** @param {Props} props */
  constructor(props) {
    super(props);
    this.state = { team: props.sector.team, level: "3", parts: "" };
  }

  /** Say what is new; what is known of visits stays. @param {Partial<Worksite>} changes */
  change(changes) {
    const { sector, onChange } = this.props;
    return onChange({ ...(/** @type {Worksite} */ (sector.worksite)), ...changes });
  }

  async goIn() {
    const { store, sector } = this.props;
    const { team, level } = this.state;
    const visit = { team: team.trim(), level: Number(level) || null, entered_unix_s: Math.round(store.serverNow()),
      left_unix_s: null, is_finished: false, parts: "" };
    const { visits } = /** @type {Worksite} */ (sector.worksite);
    if (await this.change({ visits: [...visits, visit], is_complete: false })) this.setState({ team: "" });
  }

  /** @param {Visit} visit @param {boolean} is_finished */
  async comeOut(visit, is_finished) {
    const { store, sector } = this.props;
    const left_unix_s = Math.max(visit.entered_unix_s, Math.round(store.serverNow()));
    const done = { ...visit, left_unix_s, is_finished, parts: this.state.parts.trim() };
    const { visits } = /** @type {Worksite} */ (sector.worksite);
    if (await this.change({ visits: visits.map((other) => (other === visit ? done : other)) })) this.setState({ parts: "" });
  }

  /** @param {Props} props */
  render({ store, sector, onChange }) {
    const { worksite } = sector;
    if (!worksite) {
      return html`<button type="button" title="Its front is marked with who came, what is dangerous and how far they are" onClick=${() =>
        onChange({ worksite_id: nextId(store, sector), hazards: "", triage: null, is_complete: false, visits: [] })}>Make it a worksite</button>`;
    }
    const markings = worksiteMarkings(sector, store.victims.values());
    const { live, dead, uncounted } = inside(sector, store.victims.values());
    const isAnybodyIn = worksite.visits.some(({ left_unix_s }) => left_unix_s === null);
    return html`<section class="worksite" aria-label=${`Worksite ${worksite.worksite_id}`}>
      <${Sprayed} markings=${markings} words=${markings.map(({ words }) => `${words}.`).join(" ")} />
      <p class="hint-line">By the victims on the map ${live} live and ${dead} dead are still inside${
        uncounted > 0 && `; at ${uncounted} places nobody has counted yet`}.</p>
      <div class="side-by-side">${this.text("worksite_id", "Worksite", { pattern: ID_PATTERN, maxlength: 10, title: "C-5 by INSARAG's edition of 2020, AUS01-0102 by that of 2027" })}
        <label>Triage of the worksite<select value=${worksite.triage ?? ""} onChange=${(/** @type {any} */ event) =>
          this.change({ triage: event.currentTarget.value || null })}><option value="">Not assessed</option>
          ${Object.entries(TRIAGE).map(([letter, words]) => html`<option value=${letter} selected=${letter === worksite.triage}>${letter}: ${words}</option>`)}</select></label></div>
      ${this.text("hazards", "Hazards, in plain words", { maxlength: 120 })}
      ${worksite.visits.map((visit) => this.visit(visit))}
      <div class="side-by-side"><label>Team<input maxlength="20" placeholder="AUS01" value=${this.state.team}
          onInput=${(/** @type {any} */ event) => this.setState({ team: event.currentTarget.value })}/></label>
        <label>For<select value=${this.state.level} onChange=${(/** @type {any} */ event) => this.setState({ level: event.currentTarget.value })}>
          ${LEVELS.map((words, k) => html`<option value=${k + 1} selected=${this.state.level === String(k + 1)}>ASR${k + 1}: ${words}</option>`)}</select></label></div>
      <button type="button" disabled=${!this.state.team.trim()} onClick=${() => this.goIn()}>The team goes in</button>
      <${StructureForm} worksite=${worksite} team=${this.state.team.trim()} now_s=${() => store.serverNow()}
        onChange=${(/** @type {Partial<Worksite>} */ changes) => this.change(changes)} />
      <label class="tick"><input type="checkbox" checked=${worksite.is_complete} disabled=${isAnybodyIn}
        onChange=${() => this.change({ is_complete: !worksite.is_complete })}/>No more work is needed here</label></section>`;
  }

  /** @param {Visit} visit */
  visit(visit) {
    const { team, level, entered_unix_s, left_unix_s, is_finished, parts } = visit;
    const name = `${team}${level ? `, ASR${level}` : ""}`;
    if (left_unix_s !== null) {
      return html`<p class="hint-line">${name}: ${timeOfDay(entered_unix_s)} to ${timeOfDay(left_unix_s)}, ${
        is_finished ? "all searched" : "not finished"}${parts && `, ${parts}`}.</p>`;
    }
    return html`<fieldset class="visit"><legend>${name}: inside since ${timeOfDay(entered_unix_s)}</legend>
      <label>Floors and quadrants done<input maxlength="40" placeholder="Ground Floor A to D" value=${this.state.parts}
        onInput=${(/** @type {any} */ event) => this.setState({ parts: event.currentTarget.value })}/></label>
      <div class="draft-kinds"><button type="button" onClick=${() => this.comeOut(visit, true)}>Out, all searched</button>
        <button type="button" onClick=${() => this.comeOut(visit, false)}>Out, not finished</button></div></fieldset>`;
  }

  /** @param {"worksite_id" | "hazards"} field @param {string} label @param {Record<string, unknown>} more */
  text(field, label, more) {
    const { worksite_id, [field]: value } = /** @type {Worksite} */ (this.props.sector.worksite);
    return html`<label>${label}<input key=${`${worksite_id} ${field} ${value}`} ...${more} defaultValue=${value}
      onChange=${(/** @type {any} */ event) => {
        if (event.currentTarget.validity.valid && (field === "hazards" || event.currentTarget.value)) {
          this.change({ [field]: event.currentTarget.value.trim() });
        }
      }}/></label>`;
  }
}
