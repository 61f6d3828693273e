/** What a tag's memory says, in words and as a picture of the ground round it. */

import { html } from "../console/vendor.js";
import { get, put } from "./kept.js";
import { language } from "./language.js";
import { memoryIn, memoryOnChip, sentencesOf } from "./memory.js";
import { ask, missionPath } from "./reach.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";
import { compassPoint } from "./words.js";

/** @import {Memory, Said} from "./memory.js" */

const CELL_PX = 8;
/** @type {Record<string, string>} */
const COLORS = { ".": "#0000", o: "#ffbe4d", "#": "#2f7d63" };

/** What was read from a chip by touch. @param {string} tagId @param {Uint8Array} payload of our record on it */
export function chipRead(tagId, payload) {
  changed({ memory: { tagId, isFromChip: true, ...memoryOnChip(payload) } });
}

/** What the server knows of a tag's memory, or knew when it was last in reach. @param {string} missionId @param {string} tagId */
export async function askMemory(missionId, tagId) {
  const name = `memory ${missionId} ${tagId}`;
  const known = await get("facts", name).catch(() => null);
  if (known) show(tagId, memoryIn(known.bytes));
  const response = await ask("GET", `${missionPath(missionId)}/tags/${encodeURIComponent(tagId)}/memory`);
  if (!response?.ok) return;
  const bytes = new Uint8Array(await response.arrayBuffer());
  show(tagId, memoryIn(bytes));
  await put("facts", { name, bytes }).catch(() => undefined);
}

/** @param {string} tagId @param {Said} said */
function show(tagId, said) {
  const isOlder = state.memory?.tagId === tagId && state.memory.isFromChip; // the tag itself knows best
  if (state.tagId === tagId && !isOlder) changed({ memory: { tagId, isFromChip: false, ...said } });
}

export function MemoryView() {
  const { memory: said, tagId } = state;
  if (!said || said.tagId !== tagId || (said.condition === "empty" && !said.isFromChip)) return null;
  const { condition, memory } = said;
  return html`<section class="memory"><h2>${say("memory")}</h2>
    ${condition === "empty" && html`<p>${say("memory_empty")}</p>`}
    ${condition === "damaged" && html`<p class="trouble">${say("memory_damaged")}</p>`}
    ${condition === "foreign" && html`<p class="trouble">${say("memory_foreign")}</p>`}
    ${memory && html`<ul>${sentencesOf(memory, state.roads?.north ?? null).map((text) => html`<li>${text}</li>`)}</ul><${Ground} memory=${memory} />`}
    ${memory && said.isFromChip && html`<p class="soft">${say("memory_unchecked")}</p>`}</section>`;
}

/** Covered ground round the tag, north up, or the plan's where that is not known. @param {{memory: Memory}} props */
function Ground({ memory }) {
  const { window: rows, cell_m } = memory;
  const north = state.roads?.north ?? null;
  const cells = rows.join("");
  const count = (/** @type {string} */ state) => [...cells].filter((cell) => cell === state).length;
  if (!count("o") && !count("#")) return null;
  const side = rows.length * CELL_PX;
  const middle = side / 2;
  const rim = north === null ? 0 : (Math.SQRT1_2 - 0.5) * side; // turned, its corners stand out
  const area = (/** @type {number} */ cells) => (cells * cell_m ** 2).toLocaleString(language(), { maximumFractionDigits: 1 });
  return html`<p>${say("memory_ground", { n: area(count("#") + count("o")), open: area(count("o")) })} ${say("memory_up", { way: compassPoint(0, north) })}</p>
    <svg class="ground" viewBox=${`${-rim} ${-rim} ${side + 2 * rim} ${side + 2 * rim}`} aria-hidden="true"><g transform=${`rotate(${north ?? 0} ${middle} ${middle})`}>${rows.flatMap((row, y) => [...row].map((cell, x) =>
      cell !== "." && html`<rect x=${x * CELL_PX} y=${y * CELL_PX} width=${CELL_PX} height=${CELL_PX} fill=${COLORS[cell]} />`))}</g>
      <circle cx=${middle} cy=${middle} r=${CELL_PX} fill="var(--accent)" /></svg>`;
}
