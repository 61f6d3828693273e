/** Who is logged in here, and the way out. */

import { request } from "./api.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */

/** Ask once who we are; where nobody logs in there is nothing to show. @param {Store} store */
export async function learnWho(store) {
  store.me = await request("GET", "/session").catch(() => null);
  store.changed();
}

async function logOut() {
  await request("DELETE", "/session").catch(() => null);
  location.assign("/login");
}

/** @param {{store: Store}} props */
export function Account({ store }) {
  const { me } = store;
  if (!me?.login) return null;
  const others = [...store.live.people.values()].filter(({ name }) => name !== me.name).map(({ name }) => name);
  return html`
    <details class="pop account">
      <summary aria-label=${`Logged in as ${me.name}, ${me.role}`} title="Who is here">
        <b>${me.name}</b>${others.length > 0 && html`<span class="count">+${others.length}</span>`}</summary>
      <div class="pop-card">
        <p>You are <b>${me.name}</b>, ${me.role}.</p>
        <p>${others.length ? html`Also watching: ${others.join(", ")}.` : "Nobody else is watching this mission."}</p>
        ${me.role === "commander" && html`<a href="/people">People, robots' tokens, changes</a>`}
        <button type="button" onClick=${logOut}>Log out</button>
      </div>
    </details>`;
}
