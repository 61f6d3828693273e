/** Markings as they are sprayed: strokes, rings and letters, the same here and in the report (server/markings). */

import { html } from "./vendor.js";

/** @typedef {{path: string, width: number} | {ring: [number, number, number], width: number}
 *   | {text: string, at: [number, number], size: number, anchor: string}} Shape */
/** @typedef {{name: string, words: string, width: number, height: number, shapes: Shape[]}} Marking */

const PAINT = "var(--marking)";
export const EM = 0.68; // how wide a bold letter is, as a part of its size
const MONTHS = ["JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"];

/** @param {string} path @param {number} width @returns {Shape} */
export const stroke = (path, width) => ({ path, width });

/** @param {string} text @param {number} x @param {number} y @param {number} size @param {string} [anchor] @returns {Shape} */
export const letters = (text, x, y, size, anchor = "middle") => ({ text, at: [x, y], size, anchor });

/** How many letters a text has. @param {string} text */
export const lengthOf = (text) => [...text].length;

/** The size of letters, at most `size`, at which a text takes no more than `room`. @param {string} text @param {number} size @param {number} room */
export const sizeThatFits = (text, size, room) => Math.min(size, Math.max(1, Math.floor(room / (EM * Math.max(1, lengthOf(text))))));

/** A text in lines of at most `most` letters; a longer word has a line to itself. @param {string} text @param {number} most */
export function linesOf(text, most) {
  /** @type {string[]} */
  const lines = [];
  for (const word of text.split(/\s+/).filter(Boolean)) {
    const last = lines.at(-1);
    if (last !== undefined && lengthOf(last) + 1 + lengthOf(word) <= most) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(word);
  }
  return lines;
}

/** A day like "19 OCT". @param {number} unix_s */
export function dayOf(unix_s) {
  const moment = new Date(unix_s * 1000);
  return `${moment.getDate()} ${MONTHS[moment.getMonth()]}`;
}

/** A time of day like "14:05". @param {number} unix_s */
export function hourOf(unix_s) {
  const moment = new Date(unix_s * 1000);
  return [moment.getHours(), moment.getMinutes()].map((part) => String(part).padStart(2, "0")).join(":");
}

/** @param {{markings: Marking[], words: string}} props */
export function Sprayed({ markings, words }) {
  return html`<div class="markings">${markings.map((marking, k) => html`<figure key=${k}>
      <svg viewBox=${`0 0 ${marking.width} ${marking.height}`} role="img" aria-label=${`${marking.name}: ${marking.words}`}
        class=${marking.width > 100 ? "wide" : ""}>${marking.shapes.map(drawn)}</svg>
      <figcaption>${marking.name}</figcaption></figure>`)}
    ${words && html`<p>${words}</p>`}</div>`;
}

/** @param {Shape} shape */
function drawn(shape) {
  if ("text" in shape) {
    return html`<text x=${shape.at[0]} y=${shape.at[1]} text-anchor=${shape.anchor} font-size=${shape.size} font-weight="700"
      style=${{ fill: PAINT }}>${shape.text}</text>`;
  }
  const line = { fill: "none", style: { stroke: PAINT }, "stroke-width": shape.width, "stroke-linecap": "square" };
  if ("ring" in shape) return html`<circle cx=${shape.ring[0]} cy=${shape.ring[1]} r=${shape.ring[2]} ...${line} />`;
  return html`<path d=${shape.path} ...${line} />`;
}
