/** What people have found out about the victim that is open: counts, START, team, note, which it really is. */

import { missionPath, request } from "./api.js";
import { timeOfDay } from "./format.js";
import { markingWords, victimMarkings } from "./markings.js";
import { Photos } from "./photos.js";
import { Sprayed } from "./sprayed.js";
import { Component, html } from "./vendor.js";
import { say, standing } from "./victim_list.js";

/** @import {Start, Victim} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @typedef {{audit_id: number, unix_s: number, by: string, action: string, subject: string,
 *   before: Record<string, any> | null, after: Record<string, any> | null}} Entry */

/** Which question START asks next; null when the answers decide. @param {Start} start */
export function nextQuestion(start) {
  if (start.walks === null) return "walks";
  if (start.walks) return null;
  if (start.breaths_per_min === null) return "breaths_per_min";
  if (start.breaths_per_min === 0) return start.breathes_after_airway === null ? "breathes_after_airway" : null;
  if (start.breaths_per_min > 30) return null;
  if (start.pulse === null) return "pulse";
  return start.pulse && start.obeys === null ? "obeys" : null;
}

/** @type {Record<string, [string, [string, boolean | number][]]>} */
const QUESTIONS = {
  walks: ["Can they walk?", [["Yes", true], ["No", false]]],
  breaths_per_min: ["Do they breathe? How often a minute?", [["No", 0]]],
  breathes_after_airway: ["Open the airway. Do they breathe now?", [["Yes", true], ["No", false]]],
  pulse: ["Pulse at the wrist, or capillaries refill within 2 s?", [["Yes", true], ["No", false]]],
  obeys: ["Do they follow simple commands?", [["Yes", true], ["No", false]]],
};
const NOTHING = { walks: null, breaths_per_min: null, breathes_after_airway: null, pulse: null, obeys: null };

/** @param {{victim: Victim, store: Store}} props */
export function VictimCase({ victim, store }) {
  const others = standing(store).filter(({ victim_id }) => victim_id !== victim.victim_id);
  const merged = [...store.victims.values()].filter(({ merged_into }) => merged_into === victim.victim_id);
  const isPicking = store.picking?.id === victim.victim_id && store.picking.kind === "victim";
  const move = () => {
    store.picking = isPicking ? null
      : { id: victim.victim_id, kind: "victim", then: (place) => say(store, victim, { place_m: place }) };
    store.changed();
  };
  /** @param {string} name @param {string} label @param {Record<string, unknown>} more */
  const field = (name, label, more) => html`<label>${label}
    <input name=${name} key=${`${victim.victim_id} ${/** @type {any} */ (victim)[name]}`} ...${more}
      defaultValue=${/** @type {any} */ (victim)[name] ?? ""} onChange=${(/** @type {any} */ event) => {
        const { value, validity } = event.currentTarget;
        if (validity.valid) say(store, victim, { [name]: more.type === "number" ? (value === "" ? null : Number(value)) : value });
      }}/></label>`;
  const count = { type: "number", min: 0, max: 10000, step: 1, inputmode: "numeric" };
  return html`<fieldset class="case" disabled=${store.isOver}>
    <${StartSteps} victim=${victim} store=${store} />
    <div class="case-row">${field("live", "Live there", count)}${field("dead", "Dead there", count)}${
      field("team", "Team", { maxlength: 60 })}</div>
    ${field("note", "Note", { maxlength: 2000 })}
    <${Photos} store=${store} of=${{ victim_id: victim.victim_id }} />
    <${Sprayed} markings=${victimMarkings(victim)} words=${markingWords(victim)} />
    <div class="case-row">
      <button type="button" aria-pressed=${isPicking} onClick=${move}>Move…</button>
      ${victim.place_m && html`<button type="button" onClick=${() => say(store, victim, { place_m: null })}>Where measured</button>`}
      ${others.length > 0 && html`<select aria-label=${`Victim ${victim.victim_id} is the same as`} value="" onChange=${(/** @type {any} */ event) => {
        const other = store.victims.get(event.currentTarget.value);
        if (other) say(store, other, { merged_into: victim.victim_id }); // the one that is open stays, with all that was said of it
      }}>
        <option value="">Same as…</option>${others.map(({ victim_id }) => html`<option>${victim_id}</option>`)}</select>`}
    </div>
    ${isPicking && html`<p class="order-state" role="status">Click on the plan: that is where the victim is.</p>`}
    ${merged.map((other) => html`<div class="case-row" key=${other.victim_id}><span>${other.victim_id} is the same.</span>
      <button type="button" onClick=${() => say(store, other, { merged_into: null })}>Split off</button></div>`)}
    <${History} victim=${victim} store=${store} /></fieldset>`;
}

/** What START was told, in words. @param {Start} start */
const toldOf = ({ walks, breaths_per_min, breathes_after_airway, pulse, obeys }) => [
  walks !== null && (walks ? "walks" : "cannot walk"),
  breaths_per_min !== null && (breaths_per_min ? `breathes ${breaths_per_min} times a minute` : "does not breathe"),
  breathes_after_airway !== null && `${breathes_after_airway ? "breathes" : "not even"} with the airway open`,
  pulse !== null && (pulse ? "has a pulse" : "has no pulse"),
  obeys !== null && `${obeys ? "follows" : "does not follow"} commands`,
].filter(Boolean).join(", ");

/** START, one question at a time. @param {{victim: Victim, store: Store}} props */
function StartSteps({ victim, store }) {
  const { start } = victim;
  const question = nextQuestion(start);
  const isBegun = Object.values(start).some((answer) => answer !== null);
  const again = html`<button type="button" class="quiet" onClick=${() => say(store, victim, { start: NOTHING })}>Start over</button>`;
  if (question === null) {
    return html`<div class="start"><b>START: <span class=${`triage triage-${victim.triage}`}>${victim.triage}</span></b>${again}<p>${toldOf(start)}</p></div>`;
  }
  const [words, answers] = QUESTIONS[question];
  return html`<fieldset class="start"><legend>START: ${words}</legend>
    ${answers.map(([label, value]) => html`<button type="button" onClick=${() =>
      say(store, victim, { start: { ...start, [question]: value } })}>${label}</button>`)}
    ${question === "breaths_per_min" && html`<input type="number" min="1" max="120" inputmode="numeric" placeholder="a minute"
      aria-label="Breaths a minute" onChange=${(/** @type {any} */ event) => event.currentTarget.validity.valid
        && say(store, victim, { start: { ...start, breaths_per_min: Number(event.currentTarget.value) } })}/>`}
    ${isBegun && html`${again}<p>${toldOf(start)}</p>`}</fieldset>`;
}

/** What was said, by the names of its fields. @type {Record<string, string>} */
const FIELDS = { status: "status", start: "START", live: "live there", dead: "dead there", team: "team", note: "note",
  place_m: "place", merged_into: "same as" };

/** What an entry changed, in words. @param {Entry} entry */
function changesOf({ before, after }) {
  /** @param {any} value */
  const words = (value) => (value === null || value === "" ? " taken off" : ` ${value}`);
  return Object.keys(FIELDS).filter((key) => JSON.stringify(before?.[key]) !== JSON.stringify(after?.[key]))
    .map((key) => FIELDS[key] + (["start", "place_m"].includes(key) ? "" : words(after?.[key]))).join(", ") || "the same again";
}

/** Who said what when; the latest can be taken back. */
class History extends Component {
  /** @param {{victim: Victim, store: Store}} props */
  constructor(props) {
    super(props);
    this.props = props;
    /** @type {{entries: Entry[], trouble: string, of: string, isOpen: boolean}} */
    this.state = { entries: [], trouble: "", of: "", isOpen: false };
  }

  componentDidUpdate() {
    if (this.state.isOpen) this.load();
  }

  async load() {
    const { victim, store } = this.props;
    const of = `${victim.victim_id} ${victim.changed_unix_s}`;
    if (this.state.of === of) return;
    this.setState({ of });
    try {
      const { entries } = await request("GET", `${missionPath(store.missionId ?? "")}/audit?limit=1000`);
      this.setState({ trouble: "", entries: entries.filter((/** @type {Entry} */ entry) => entry.subject === victim.victim_id).slice(0, 20) });
    } catch (error) {
      this.setState({ trouble: /** @type {Error} */ (error).message });
    }
  }

  /** @param {Entry} entry */
  async takeBack(entry) {
    const { store } = this.props;
    try {
      await request("POST", `${missionPath(store.missionId ?? "")}/audit/${entry.audit_id}/undo`);
    } catch (error) {
      store.notify(`Not taken back. ${/** @type {Error} */ (error).message}`);
    }
  }

  render() {
    const { entries, trouble } = this.state;
    return html`<details class="history" onToggle=${(/** @type {any} */ event) => this.setState({ isOpen: event.currentTarget.open })}>
      <summary>History</summary>
      ${trouble && html`<p>${trouble}</p>`}
      ${!trouble && entries.length === 0 && html`<p>Nobody has said anything about this victim yet.</p>`}
      <ol>${entries.map((/** @type {Entry} */ entry, /** @type {number} */ k) => html`<li key=${entry.audit_id}>
        <time>${timeOfDay(entry.unix_s)}</time> ${entry.by} ${entry.action === "take_back" ? "took a change back" : "said"}: ${changesOf(entry)}
        ${k === 0 && entry.action === "judge_victim" && html` <button type="button" class="quiet"
          onClick=${() => this.takeBack(entry)}>Undo</button>`}</li>`)}</ol></details>`;
  }
}
