/** Live or best map: the switch at the plan, and words on how old the best map is, or why there is none. */

import { color } from "../theme.js";
import { robotColor } from "./color.js";
import { age, metres } from "./format.js";
import { html } from "./vendor.js";

/** @import {BestMap} from "./best_map.js" */
/** @import {Store} from "./store.js" */
/** @import {View} from "./canvas_layer.js" */

/** @param {{store: Store}} props */
export function MapSwitch({ store }) {
  const { best } = store;
  if (!store.mission || store.past.board) return null;
  return html`
    <div class="map-switch" role="group" aria-label="Which map">
      <button type="button" aria-pressed=${!best.isShown} onClick=${() => best.showLive()}
              title="What the robots know now (B)">Live</button>
      <button type="button" aria-pressed=${best.isShown} onClick=${() => best.show()}
              title="Everything recorded, solved again in one go (B)">Best map</button>
    </div>
    ${best.isShown && best.content && html`<${BestStatus} store=${store} />`}`;
}

/** In the middle of the plan, while there is no best map to draw. @param {{store: Store}} props */
export function BestWords({ store }) {
  const { best } = store;
  if (!best.isShown || best.content) return null;
  const { line, detail } = words(store);
  return html`<div class="best-words"><${Busy} best=${best} />
    <div role="status"><strong>${line}</strong><p>${detail}</p></div><${Again} best=${best} /></div>`;
}

/** In the corner, while one is drawn. @param {{store: Store}} props */
function BestStatus({ store }) {
  const { best } = store;
  const { line, detail, level } = words(store);
  return html`<div class=${`best-status ${level}`}>
    <div role="status"><b>${line}</b>${detail && html`<span>${detail}</span>`}</div>
    <${Busy} best=${best} /><${Again} best=${best} /></div>`;
}

/** @param {{best: BestMap}} props */
const Busy = ({ best }) => best.isSolving && html`<i class="busy" aria-hidden="true"></i>`;

/** @param {{best: BestMap}} props */
const Again = ({ best }) => !best.isSolving && html`<button type="button" onClick=${() => best.solve()}>
  ${best.state ? "Solve again" : "Solve"}</button>`;

/**
 * How the best map stands: one line, and a sentence where more is to be said.
 * @param {Store} store
 */
function words(store) {
  const { best } = store;
  const { state } = best;
  const solved = state?.solved_unix_s ? `Solved ${solvedAgo(store, state.solved_unix_s)}` : "";
  if (best.isSolving) {
    const { robots_done: done = 0, robots_total: total = 0 } = state?.state === "solving" ? state : {};
    const line = total > 1 ? `Solving… ${done} of ${total} robots` : "Solving…";
    const first = "Everything recorded is solved in one go. It takes seconds to minutes; the robots go on meanwhile.";
    return { line, detail: solved ? `${solved}: that one is shown until then.` : first, level: "" };
  }
  if (best.trouble) return { line: solved || "No best map", detail: best.trouble, level: "warning" };
  if (state?.state === "failed") {
    const detail = solved ? `${state.reason} Shown is the earlier one: ${solved.toLowerCase()}.` : state.reason;
    return { line: "Solving failed", detail, level: "warning" };
  }
  if (!solved) {
    return { line: "No best map yet", detail: "It is made when you ask: everything recorded, solved in one go.", level: "" };
  }
  if (!best.content) return { line: "Loading the best map", detail: `${solved}.`, level: "" };
  const notes = (state?.left_out ?? []).map(({ robot_id, reason }) => `Without ${robot_id}: ${reason}.`);
  if (!best.content.map) notes.push("There is no picture: no robot has sent scans.");
  const outrun = best.outrun();
  if (outrun) notes.unshift(`Robots have driven ${metres(best.drivenSince_m())} since.`);
  else if (!state?.left_out.length) {
    notes.unshift(best.isStale() ? "Robots have hardly moved since." : "All that robots have seen is in it.");
  }
  const level = outrun === "stale" ? "stale" : state?.left_out.length ? "warning" : "";
  return { line: outrun === "stale" ? `${solved} · stale` : solved, detail: notes.join(" "), level };
}

/**
 * @param {Store} store
 * @param {number} unix_s
 */
function solvedAgo(store, unix_s) {
  const text = age(Math.max(0, store.serverNow() - unix_s));
  return text === "now" ? "just now" : text;
}

/**
 * Where each robot was when the best map was made: a ring at the end of its trail, for its mark is not shown.
 * @param {Store} store
 */
export const drawEnds = (store) =>
  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   */
  (ctx, view) => {
    if (!store.best.isShown || !store.layers.trails) return;
    for (const robot of store.best.content?.robots ?? []) {
      if (!robot.located) continue;
      const [x, y] = [view.toX(robot.x_m), view.toY(robot.y_m)];
      const own = robotColor(robot.robot_id);
      ctx.beginPath();
      ctx.arc(x, y, 6, 0, 2 * Math.PI);
      for (const [style, width] of /** @type {const} */ ([[color("halo"), 5], [own, 2.5]])) {
        ctx.strokeStyle = style;
        ctx.lineWidth = width;
        ctx.stroke();
      }
    }
  };
