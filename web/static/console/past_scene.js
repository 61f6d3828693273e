/** The past in 3D: while it is looked at, a scene of one's own lies over the live one and follows the moment. */

import { shownTheme } from "../theme.js";
import { missionPath } from "./api.js";
import { socketAddress, takeClick, wishOf } from "./view_link.js";

/** @import {Store} from "./store.js" */

const PAUSE_MS = 150; // between two moments that are asked for
const RETRY_MS = 2000;

export class PastScene {
  /**
   * @param {HTMLElement} root
   * @param {Store} store
   */
  constructor(root, store) {
    this.root = root;
    this.store = store;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {HTMLElement | null} */
    this.cover = null;
    this.sent_s = 0;
    this.sentWish = "";
    this.isWaiting = true;
    store.subscribe(() => this.update());
  }

  update() {
    const { past, view, missionId } = this.store;
    if (past.at_s === null || view === "plan" || !missionId) {
      if (this.cover) this.#leave();
      return;
    }
    if (!this.cover) this.#enter(missionId);
    // The live scene, once loaded, takes the whole pane.
    if (this.cover && !this.cover.isConnected) this.root.append(this.cover);
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const wish = JSON.stringify(wishOf(this.store));
    if (wish !== this.sentWish) this.socket.send((this.sentWish = wish));
    if (this.isWaiting || this.sent_s === past.at_s) return;
    this.isWaiting = true; // until the scene has got there: it is never asked for more than it can draw
    this.sent_s = past.at_s;
    this.socket.send(JSON.stringify({ unix_s: past.at_s }));
  }

  /** @param {string} missionId */
  #enter(missionId) {
    this.cover = document.createElement("div");
    this.cover.className = "past-scene";
    this.#say("Bringing the past into 3D.");
    this.root.append(this.cover);
    this.#open(missionId);
  }

  /** @param {string} missionId */
  #open(missionId) {
    this.isWaiting = true;
    this.sent_s = 0;
    this.sentWish = "";
    const socket = new WebSocket(socketAddress(`${missionPath(missionId)}/history/view?theme=${shownTheme()}`));
    socket.onmessage = (event) => this.#receive(JSON.parse(event.data));
    socket.onclose = (event) => {
      this.#say(`The past cannot be shown in 3D: ${event.reason || "the server does not answer"}. It is tried again; the plan shows it.`);
      setTimeout(() => this.socket === socket && this.#open(missionId), RETRY_MS);
    };
    this.socket = socket;
  }

  /** @param {{scene?: string, clicked?: {kind: string, id: string}}} message */
  #receive({ scene, clicked }) {
    if (clicked) {
      takeClick(this.store, clicked);
      return;
    }
    if (scene) {
      const frame = document.createElement("iframe");
      frame.title = "The mission's past in 3D";
      frame.src = `/viser/${encodeURIComponent(scene)}/?hideViserLogo${shownTheme() === "dark" ? "&darkMode" : ""}`;
      frame.addEventListener("load", () => frame.nextElementSibling?.remove());
      this.cover?.prepend(frame);
    }
    setTimeout(() => {
      this.isWaiting = false;
      this.update();
    }, PAUSE_MS);
  }

  #leave() {
    if (this.socket) this.socket.onclose = null;
    this.socket?.close();
    this.cover?.remove();
    this.cover = this.socket = null;
    this.sent_s = 0;
  }

  /** @param {string} text */
  #say(text) {
    const words = document.createElement("p");
    words.setAttribute("role", "status");
    words.textContent = text;
    this.cover?.replaceChildren(words);
  }
}
