/** Find a robot, tag, victim or note by a part of its name, and go there. */

import { understood } from "../phone/short_id.js";
import { NOTE_KINDS } from "./note_kinds.js";
import { Component, html } from "./vendor.js";

/** @import {Selected, Store} from "./store.js" */
/** @typedef {Selected & {name: string, what: string}} Found */

const MOST = 8;

/** The best matches for what is typed, whole names first. @param {Store} store @param {string} typed @returns {Found[]} */
export function find(store, typed) {
  const words = typed.trim().toLowerCase();
  if (!words) return [];
  /** @type {Found[]} */
  const all = [
    ...[...store.robots.keys()].map((id) => ({ kind: /** @type {const} */ ("robot"), id, name: id, what: "Robot" })),
    ...[...store.victims.values()].filter(({ merged_into }) => !merged_into).map(({ victim_id: id, status, note }) => (
      { kind: /** @type {const} */ ("victim"), id, name: id, what: `Victim, ${status}${note && `: ${note}`}` })),
    ...[...store.annotations].map(([id, { kind, text }]) => (
      { kind: /** @type {const} */ ("note"), id, name: text || kind, what: NOTE_KINDS[kind]?.label ?? kind })),
    ...[...store.shown.tags.keys()].map((id) => ({ kind: /** @type {const} */ ("tag"), id, name: id, what: "Tag" })),
  ];
  const meant = understood(typed, store.shown.tags.keys()).tagIds; // as a label has it, with its check character
  /** @param {Found} found */
  const rank = ({ kind, id, name, what }) => kind === "tag" && meant.includes(id) ? -1 : [name, what].map((text) => text.toLowerCase().indexOf(words))
    .reduce((best, at, k) => (at < 0 ? best : Math.min(best, 100 * k + Math.min(at, 99))), 1000);
  return all.map((found) => /** @type {const} */ ([rank(found) + (found.name.length > words.length ? 0.5 : 0), found]))
    .filter(([place]) => place < 1000)
    .sort(([a, one], [b, other]) => a - b || one.name.localeCompare(other.name, "en", { numeric: true }))
    .slice(0, MOST).map(([, found]) => found);
}

/** @extends {Component<{store: Store, onSelect: (found: Selected) => void}, {typed: string}>} */
export class Search extends Component {
  /** Empty the field, and give the keys back to the plan. */
  leave() {
    this.setState({ typed: "" });
    document.getElementById("plan")?.focus();
  }

  /** @param {Found} found */
  choose(found) {
    this.leave();
    this.props.onSelect({ kind: found.kind, id: found.id });
  }

  /** Arrows go through what was found, Escape leaves. @param {KeyboardEvent} event */
  key(event) {
    const root = /** @type {HTMLElement} */ (event.currentTarget);
    const stops = /** @type {HTMLElement[]} */ ([...root.querySelectorAll("input, button")]);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (event.key === "Escape") this.leave();
    else if (step) stops[(stops.indexOf(/** @type {any} */ (document.activeElement)) + step + stops.length) % stops.length]?.focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {{store: Store, onSelect: (found: Selected) => void}} props */
  render({ store }) {
    const typed = this.state.typed ?? "";
    const found = find(store, typed);
    return html`<form class="search" role="search" onKeyDown=${(/** @type {any} */ event) => this.key(event)}
        onSubmit=${(/** @type {Event} */ event) => { event.preventDefault(); if (found[0]) this.choose(found[0]); }}>
      <input id="search" type="search" autocomplete="off" spellcheck="false" placeholder="Find (/)"
        aria-label="Find a robot, tag, victim or note" value=${typed}
        onInput=${(/** @type {any} */ event) => this.setState({ typed: event.currentTarget.value })} />
      ${typed.trim() && html`<ul class="found" aria-label="Found">${found.map((each) => html`
        <li key=${`${each.kind}/${each.id}`}><button type="button" onClick=${() => this.choose(each)}>
          <b>${each.name}</b><span>${each.what}</span></button></li>`)}
        ${!found.length && html`<li role="status">Nothing here is called that.</li>`}</ul>`}
    </form>`;
  }
}
