/** What a team marks at a worksite's front beside its search: how safe the structure is, and that nobody alive is left. */

import { timeOfDay } from "./format.js";
import { ARROWS } from "./structure_marks.js";
import { Component, html } from "./vendor.js";

/** @import {Rating, Worksite} from "./types.js" */
/** @typedef {{worksite: Worksite, team: string, now_s: () => number, onChange: (changes: Partial<Worksite>) => void}} Props */

/** FEMA's levels of risk. @type {Record<Rating["risk"], string>} */
const RISKS = { low: "Low risk", moderate: "Moderate risk", high: "High risk" };

/** @extends {Component<Props, {risk: Rating["risk"], entry: Rating["entry"]}>} */
export class StructureForm extends Component {
  /** @param {Props} props */
  constructor(props) {
    super(props);
    /** @type {Pick<Rating, "risk" | "entry">} */
    this.state = { risk: "moderate", entry: null };
  }

  rate() {
    const { worksite, team, now_s, onChange } = this.props;
    onChange({ ratings: [...(worksite.ratings ?? []), { team, ...this.state, rated_unix_s: Math.round(now_s()) }] });
  }

  /** @param {"clear" | "deceased"} found */
  clear(found) {
    const { worksite, team, now_s, onChange } = this.props;
    onChange({ clearances: [...(worksite.clearances ?? []), { team, found, cleared_unix_s: Math.round(now_s()) }] });
  }

  /** @param {Props} props */
  render({ worksite, team }) {
    const said = [...(worksite.ratings ?? []).map((each) => `${each.team}: ${RISKS[each.risk].toLowerCase()}, ${timeOfDay(each.rated_unix_s)}.`),
      ...(worksite.clearances ?? []).map((each) => `${each.team}: ${each.found === "clear" ? "clear" : "deceased only"}, ${timeOfDay(each.cleared_unix_s)}.`)];
    return html`${said.map((words) => html`<p class="hint-line">${words}</p>`)}
      <div class="side-by-side"><label>Structure<select onChange=${(/** @type {any} */ event) => this.setState({ risk: event.currentTarget.value })}>
          ${Object.entries(RISKS).map(([risk, words]) => html`<option value=${risk} selected=${risk === this.state.risk}>${words}</option>`)}</select></label>
        <label>Safest entry<select onChange=${(/** @type {any} */ event) => this.setState({ entry: event.currentTarget.value || null })}>
          <option value="">Not shown</option>${Object.keys(ARROWS).map((entry) => html`<option value=${entry} selected=${entry === this.state.entry}>
            ${entry[0].toUpperCase()}${entry.slice(1)}</option>`)}</select></label></div>
      <div class="draft-kinds"><button type="button" disabled=${!team} onClick=${() => this.rate()}>Mark how safe it is</button></div>
      <div class="draft-kinds" role="group" aria-label="Rapid clearance, after a full search"><button type="button" disabled=${!team}
          title="Searched all through: nobody is left" onClick=${() => this.clear("clear")}>C: clear</button>
        <button type="button" disabled=${!team} title="Searched all through: only deceased are left" onClick=${() => this.clear("deceased")}>D: deceased only</button></div>`;
  }
}
