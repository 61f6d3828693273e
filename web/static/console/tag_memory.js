/** What the selected tag's memory says: the ground round it as a small picture, and the rest in sentences. */

import { missionPath, request } from "./api.js";
import { Component, html } from "./vendor.js";

/** @import {Store} from "./store.js" */

const AGAIN_MS = 5000;
/** @type {Record<string, string>} */
const CELL_COLORS = { o: "var(--warn)", "#": "var(--seen)" };

/**
 * @typedef {{window: string[]}} Memory
 * @typedef {{cell_m: number, memory: Memory, sentences: string[]}} Content
 * @extends {Component<{store: Store, tagId: string}, {content: Content | null, words: string}>}
 */
export class TagMemory extends Component {
  timer = 0;

  componentDidMount() {
    this.#ask();
    this.timer = setInterval(() => this.#ask(), AGAIN_MS);
  }

  componentWillUnmount() {
    clearInterval(this.timer);
  }

  async #ask() {
    const { store, tagId } = this.props;
    const path = `${missionPath(store.missionId ?? "")}/tags/${encodeURIComponent(tagId)}/memory/content`;
    try {
      this.setState({ content: await request("GET", path), words: "" });
    } catch (error) {
      this.setState({ words: /** @type {Error} */ (error).message });
    }
  }

  render() {
    const { content, words } = this.state;
    if (!content) return html`<p>${words ?? "Asking what its memory says."}</p>`;
    if (!content.memory) return html`<p>${content.sentences.join(" ")}</p>`;
    const rows = content.memory.window;
    const side_m = rows.length * content.cell_m;
    const seen = rows.join("").replaceAll(".", "").length * content.cell_m ** 2;
    return html`
      <figure class="tag-memory">
        ${seen > 0 && html`<${Window} rows=${rows} />`}
        <figcaption>${seen > 0
          ? html`It tells of ${seen} m² round it, ${side_m} m across.
            <span class="key"><i style=${{ background: CELL_COLORS["#"] }}></i>covered
              <i style=${{ background: CELL_COLORS.o }}></i>covered, with an open edge</span>`
          : "It tells of no ground yet."}</figcaption>
      </figure>
      ${content.sentences.length > 0 && html`<ul class="tag-sentences">
        ${content.sentences.map((sentence) => html`<li>${sentence}</li>`)}</ul>`}`;
  }
}

/** The window as it lies on the plan, the tag in the middle; its first row is farthest along x. @param {{rows: string[]}} props */
function Window({ rows }) {
  const side = rows.length;
  const cells = rows.flatMap((row, r) => [...row].flatMap((cell, c) =>
    cell in CELL_COLORS ? [html`<rect x=${side - 1 - r} y=${c} width="1.02" height="1.02" style=${{ fill: CELL_COLORS[cell] }} />`] : []));
  return html`<svg viewBox=${`0 0 ${side} ${side}`} role="img" aria-label="The ground round the tag, as it lies on the plan">
    ${cells}<circle cx=${side / 2} cy=${side / 2} r=${side / 40 + 0.25} class="here" stroke-width="0.2" /></svg>`;
}
