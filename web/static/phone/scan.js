/** The camera on the page: hold it on a label, and its tag opens. What keeps it from working is said in words. */

import { Component, html } from "../console/vendor.js";
import { watchCamera } from "./camera.js";
import { changed } from "./state.js";
import { say } from "./texts.js";

/** @type {Record<string, import("./texts.js").Key>} */
const WHY = {
  NotAllowedError: "camera_refused",
  NotFoundError: "camera_none",
  NotReadableError: "camera_busy",
  SecurityError: "camera_insecure",
  NetworkError: "reader_missing",
};

/** @extends {Component<{onText: (text: string) => void}>} */
export class Scan extends Component {
  over = new AbortController();
  /** @type {HTMLVideoElement | null} */ video = null;

  componentDidMount() {
    if (!this.video) return;
    watchCamera(this.video, (text) => this.props.onText(text), this.over.signal).catch((error) => {
      changed({ scanning: false, trouble: say(WHY[error?.name] ?? "camera_broken") });
      scrollTo(0, 0);
    });
  }

  componentWillUnmount() {
    this.over.abort();
  }

  render() {
    /** @param {HTMLVideoElement | null} video */
    const keep = (video) => { this.video = video; };
    return html`<section class="scan"><video ref=${keep} muted playsinline aria-label=${say("camera_picture")}></video>
      <p>${say("hold_on_label")}</p>
      <button type="button" onClick=${() => changed({ scanning: false })}>${say("camera_off")}</button></section>`;
  }
}
