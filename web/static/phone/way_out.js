/** The way out: to the nearest exit that somebody has marked. */

import { html } from "../console/vendor.js";
import { state } from "./state.js";
import { say } from "./texts.js";
import { lead, notesWith, target } from "./touch.js";
import { routeTo } from "./where.js";
import { metres } from "./words.js";

/** @import {Pocket, Route} from "./types.js" */

/** The exits of a mission as goals of routes: a tag where one was marked at it, else its place. @param {Pocket} pocket */
const exitsOf = (pocket) => notesWith(pocket).filter(({ kind }) => kind === "exit")
  .map(({ annotation_id, tag_id }) => (tag_id ? `tag:${tag_id}` : `note:${annotation_id}`));

export function WayOut() {
  const { pocket, roads, where } = state;
  if (!pocket || !roads || !where) return null;
  const exits = exitsOf(pocket);
  if (!exits.length) return html`<p class="soft">${say("no_exit")}</p>`;
  const ways = exits.map((to) => ({ to, route: routeTo(pocket, roads, where.tag_id, to) }))
    .filter(/** @returns {way is {to: string, route: Route}} */ (way) => way.route !== null)
    .sort((a, b) => a.route.distance_m - b.route.distance_m);
  if (!ways.length) return html`<p class="soft">${say("no_way_out")}</p>`;
  const [{ to, route }] = ways;
  if (target()?.to === to) return null;
  return html`<ul><li><button type="button" onClick=${() => lead(to)}><span>${say("way_out")}</span>
    <span class="far">${route.distance_m ? metres(route.distance_m) : say("here")}</span></button></li></ul>`;
}
