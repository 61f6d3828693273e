/** Handing reports to another phone: codes on this screen, one after the other; and taking them off another's. */

// @ts-ignore the library's types go by another name than the browser's
import { correction, generate } from "/vendor/lean-qr/index.mjs";
import { Component, html } from "../console/vendor.js";
import { Collector, framesOf } from "./handover.js";
import { adopt, waiting } from "./outbox.js";
import { textOf } from "./report_words.js";
import { changed } from "./state.js";
import { say } from "./texts.js";

const EACH_MS = 450;
const QUIET = 4;

export class HandOver extends Component {
  constructor() {
    super();
    this.state = { frames: [], k: 0 };
    this.timer = 0;
  }

  async componentDidMount() {
    this.setState({ frames: await framesOf(waiting()) });
    this.timer = setInterval(() => this.setState({ k: (this.state.k + 1) % Math.max(1, this.state.frames.length) }), EACH_MS);
  }

  componentWillUnmount() {
    clearInterval(this.timer);
  }

  render() {
    const { frames, k } = this.state;
    if (!frames.length) return null;
    return html`<section class="handover"><p>${say("handover_how")}</p>
      <${Code} text=${frames[k]} /><p role="status">${say("handover_count", { k: k + 1, n: frames.length })}</p></section>`;
  }
}

/** @param {{text: string}} props */
function Code({ text }) {
  const code = generate(text, { minCorrectionLevel: correction.M });
  const side = code.size + 2 * QUIET;
  let path = "";
  for (let y = 0; y < code.size; y += 1) for (let x = 0; x < code.size; x += 1) if (code.get(x, y)) path += `M${x} ${y}h1v1h-1z`;
  return html`<svg class="code" data-code=${text} viewBox=${`0 0 ${side} ${side}`} role="img" aria-label=${say("handover_code")}
    shape-rendering="crispEdges"><rect width=${side} height=${side} fill="#fff" />
    <path transform=${`translate(${QUIET} ${QUIET})`} d=${path} fill="#000" /></svg>`;
}

/** What speaks of people, not of places, and calls others: whoever made the code may have made it up. */
const ASKED_FOR = ["mayday", "heard", "at"];
/** @type {import("./outbox.js").Report[]} */
let offered = [];

/** What another phone hands over that has to be looked at first. */
export function Offered() {
  if (!offered.length) return null;
  return html`<section role="alert"><p>${say("handover_ask")}</p>
    <ul>${offered.map((report) => html`<li key=${report.id} class="waiting">${textOf(report)}</li>`)}</ul>
    <div class="row"><button type="button" onClick=${() => answerOffer(true)}>${say("handover_take")}</button>
    <button type="button" onClick=${() => answerOffer(false)}>${say("handover_leave")}</button></div></section>`;
}

/** Take what was offered, or leave it with the other phone. @param {boolean} isTaken */
export async function answerOffer(isTaken) {
  const reports = offered;
  offered = [];
  if (isTaken) await adopt(reports);
  changed({ said: isTaken ? say("handover_done", { n: reports.length }) : "" });
}

let collector = new Collector();

/**
 * @param {string} text of a code the camera sees
 * @returns {Promise<void> | null} null where it is none of another phone's reports; kept once what is whole now has been taken over
 */
export function takeCode(text) {
  if (!collector.take(text)) return null;
  changed({ said: say("handover_got", { k: collector.parts.size, n: collector.count }) });
  return collector.isWhole ? finish(collector) : Promise.resolve();
}

/** @param {Collector} whole */
async function finish(whole) {
  collector = new Collector();
  try {
    const reports = await whole.reports();
    const plain = reports.filter(({ kind }) => !ASKED_FOR.includes(kind));
    await adopt(plain);
    const asked = reports.filter(({ id, kind }) => ASKED_FOR.includes(kind) && !offered.some((known) => known.id === id));
    offered = [...offered, ...asked];
    changed({ scanning: false, said: plain.length ? say("handover_done", { n: plain.length }) : "" });
  } catch {
    changed({ scanning: false, said: "", trouble: say("handover_damaged") });
  }
  scrollTo(0, 0);
}
