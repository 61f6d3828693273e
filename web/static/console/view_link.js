/** The line to this page's own 3D view: what is selected here is marked there, what is clicked there is selected here. */

import { missionPath } from "./api.js";
import { openPhoto } from "./photos.js";
import { openSector } from "./sectors.js";

/** @import {Store} from "./store.js" */

const RETRY_MS = 1500;

/** What the view is to mark, whether to go along with it, and how often it was put into the middle. @param {Store} store */
export function wishOf({ selected, sectorPanel, follows, centred }) {
  const sector = sectorPanel?.id ? ["sector", sectorPanel.id] : null;
  return { selected: selected ? [selected.kind, selected.id] : sector, follows, centred };
}

/** @param {Store} store @param {{kind: any, id: string}} clicked */
export function takeClick(store, { kind, id }) {
  if (kind === "photo") openPhoto(store, id);
  else if (kind === "sector") {
    store.selected = null; // else that stays marked, with its card over the sector's
    openSector(store, id);
  } else store.select({ kind, id });
}

/** @param {string} path under /api/v1 */
export const socketAddress = (path) => `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/v1${path}`;

export class ViewLink {
  /**
   * @param {Store} store
   * @param {string} missionId
   * @param {(reason: string) => void} told called when the scene is there, and with the reason when it cannot be
   */
  constructor(store, missionId, told) {
    this.store = store;
    this.missionId = missionId;
    this.told = told;
    /** The seat's address under /viser; it stays the same when the line is opened again. */
    this.scene = "";
    this.sent = "";
    // A secret of this page: a view that is opened by it answers to nobody else.
    this.seat = [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    /** @type {WebSocket | null} */
    this.socket = null;
    this.#open();
  }

  #open() {
    const socket = new WebSocket(socketAddress(`${missionPath(this.missionId)}/view?seat=${this.seat}`));
    this.socket = socket;
    socket.onmessage = (event) => {
      const { scene, clicked } = JSON.parse(event.data);
      if (clicked) takeClick(this.store, clicked);
      if (!scene) return;
      this.scene = scene;
      this.sent = "";
      this.update();
      this.told("");
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      if (!this.scene) this.told(event.reason || "the server does not answer");
      setTimeout(() => this.socket === socket && this.#open(), RETRY_MS);
    };
  }

  /** Tell the view what has changed. */
  update() {
    const wish = JSON.stringify(wishOf(this.store));
    if (wish === this.sent || !this.scene || this.socket?.readyState !== WebSocket.OPEN) return;
    this.sent = wish;
    this.socket.send(wish);
  }

  close() {
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }
}
