/** A victim at this tag: how many live and dead (INSARAG), and START step by step; each answer is one touch. */

import { Component, html } from "../console/vendor.js";
import { add } from "./outbox.js";
import { changed, missionId, state } from "./state.js";
import { say } from "./texts.js";

/** @typedef {import("./texts.js").Key} Key */
/** @typedef {{walks: boolean | null, breaths_per_min: number | null, breathes_after_airway: boolean | null, pulse: boolean | null,
 *   obeys: boolean | null}} Start */

/** @type {Start} */
const NOTHING = { walks: null, breaths_per_min: null, breathes_after_airway: null, pulse: null, obeys: null };

/** The question of START that comes next, null where the answers decide. @param {Start} start @returns {keyof Start | null} */
export function nextQuestion({ walks, breaths_per_min, breathes_after_airway, pulse, obeys }) {
  if (walks) return null;
  if (walks === null) return "walks";
  if (breaths_per_min === null) return "breaths_per_min";
  if (breaths_per_min === 0) return breathes_after_airway === null ? "breathes_after_airway" : null;
  if (breaths_per_min > 30 || pulse === false) return null;
  if (pulse === null) return "pulse";
  return obeys === null ? "obeys" : null;
}

/** The category of START; "unknown" until the answers decide. As db/victim_records.py has it. @param {Start} start */
export function triageOf(start) {
  if (start.walks) return "minor";
  if (nextQuestion(start)) return "unknown";
  if (start.breaths_per_min === 0) return start.breathes_after_airway ? "immediate" : "deceased";
  return Number(start.breaths_per_min) > 30 || start.pulse === false || !start.obeys ? "immediate" : "delayed";
}

/** Answers to "how many breaths a minute": none, up to 30, more. */
const BREATHS = /** @type {const} */ ([["breaths_none", 0], ["breaths_slow", 20], ["breaths_fast", 36]]);

export class VictimForm extends Component {
  constructor() {
    super();
    this.state = { live: 1, dead: 0, text: "", start: NOTHING };
  }

  /** @param {SubmitEvent} event */
  async send(event) {
    event.preventDefault();
    const { live, dead, text, start } = this.state;
    await add("victim", missionId(), { tag_id: state.tagId, live, dead, text: text.trim(), start });
    const word = { tagId: state.tagId, text: `victim: L-${live} D-${dead} ${text.trim()}`.trim() };
    changed({ form: "", word, said: say("left_at", { kind: say("kind_victim"), tag: state.tagId }), trouble: "" });
  }

  render() {
    const { text, start } = this.state;
    const question = nextQuestion(start);
    return html`<form class="victim" onSubmit=${(/** @type {SubmitEvent} */ event) => this.send(event)}>
      <h2>${say("victims_here")}</h2>
      ${this.count("live")} ${this.count("dead")}
      ${question ? this.question(question) : html`<p role="status">${say(/** @type {Key} */ (`triage_${triageOf(start)}`))}</p>`}
      ${start !== NOTHING && html`<button type="button" onClick=${() => this.setState({ start: NOTHING })}>${say("start_again")}</button>`}
      <label>${say("what_else")}<input maxlength="2000" value=${text}
        onInput=${(/** @type {any} */ event) => this.setState({ text: event.currentTarget.value })} /></label>
      <button type="submit">${say("leave_victim")}</button></form>`;
  }

  /** @param {"live" | "dead"} name */
  count(name) {
    const label = say(/** @type {Key} */ (name));
    const now = this.state[name];
    const set = (/** @type {number} */ value) => this.setState({ [name]: Math.max(0, Math.min(99, value)) });
    return html`<div class="count-row" role="group" aria-label=${label}><span>${label}</span>
      <button type="button" aria-label=${say("one_less", { what: label })} onClick=${() => set(now - 1)}>−</button>
      <output>${now}</output>
      <button type="button" aria-label=${say("one_more", { what: label })} onClick=${() => set(now + 1)}>+</button></div>`;
  }

  /** @param {keyof Start} name */
  question(name) {
    const answer = (/** @type {boolean | number} */ value) => this.setState({ start: { ...this.state.start, [name]: value } });
    const answers = name === "breaths_per_min" ? BREATHS : /** @type {const} */ ([["yes", true], ["no", false]]);
    return html`<fieldset><legend>${say(/** @type {Key} */ (`ask_${name}`))}</legend><div class="row">${answers.map(([key, value]) => html`
      <button type="button" onClick=${() => answer(value)}>${say(key)}</button>`)}</div></fieldset>`;
  }
}
