/** Operational periods: who commands, what for, since when. */

import { missionPath, request } from "./api.js";
import { timeOfDay } from "./format.js";
import { Component, html } from "./vendor.js";

/** @import {Store} from "./store.js" */

/** @extends {Component<{store: Store}, {isOpen: boolean, commander: string, objectives: string, trouble: string}>} */
export class Periods extends Component {
  /** @param {{store: Store}} props */
  constructor(props) {
    super(props);
    this.state = { isOpen: false, commander: props.store.me?.name ?? "", objectives: "", trouble: "" };
  }

  /** @param {string} end address after the mission's @param {object} [body] */
  async send(end, body) {
    try {
      await request("POST", `${missionPath(this.props.store.missionId ?? "")}/${end}`, body);
      this.setState({ isOpen: false, objectives: "", trouble: "" });
    } catch (error) {
      this.setState({ trouble: /** @type {Error} */ (error).message });
    }
  }

  /** @param {{store: Store}} props */
  render({ store }) {
    const { isOpen, commander, objectives, trouble } = this.state;
    const periods = [...store.periods.values()].sort((a, b) => a.number - b.number);
    const last = periods.at(-1);
    const goesOn = last !== undefined && last.ended_unix_s === null;
    const may = !store.isOver && store.may("commander");
    return html`<p class="period">${goesOn ? html`<b>Operational period ${last.number}</b> under ${last.commander} since ${timeOfDay(last.begun_unix_s)}.${
        last.objectives && ` ${last.objectives}`}`
        : last ? `Operational period ${last.number} under ${last.commander} was over at ${timeOfDay(last.ended_unix_s ?? 0)}.` : "No operational period has begun."}</p>
      ${may && html`<div class="draft-kinds"><button type="button" aria-expanded=${isOpen} onClick=${() => this.setState({ isOpen: !isOpen })}>${
        goesOn ? "Begin the next period…" : "Begin a period…"}</button>
        ${goesOn && html`<button type="button" onClick=${() => this.send("periods/end")}>End it</button>`}</div>`}
      ${may && isOpen && html`<label>Commander<input maxlength="60" value=${commander} onInput=${(/** @type {any} */ event) =>
          this.setState({ commander: event.currentTarget.value })}/></label>
        <label>Objectives<input maxlength="2000" value=${objectives} onInput=${(/** @type {any} */ event) =>
          this.setState({ objectives: event.currentTarget.value })}/></label>
        <button type="button" disabled=${!commander.trim()} onClick=${() =>
          this.send("periods", { commander: commander.trim(), objectives: objectives.trim() })}>Begin</button>`}
      ${trouble && html`<p class="warn" role="alert">${trouble}</p>`}`;
  }
}
