/** The 3D view: viser's page in a frame, loaded only when it is first asked for. */

import { shownTheme } from "../theme.js";
import { fetchChecked } from "./api.js";
import { ViewLink } from "./view_link.js";

const NO_WEBGL = "none";

/** @import {Store} from "./store.js" */

export class Scene {
  /**
   * @param {HTMLElement} root
   * @param {Store} store
   */
  constructor(root, store) {
    this.root = root;
    this.store = store;
    /** Address of what is loaded. */
    this.shown = "";
    /** @type {ViewLink | null} */
    this.link = null;
    store.subscribe(() => this.update());
  }

  /** Load the mission's scene when it should be visible and is not there yet. */
  update() {
    const { missionId, view, connection } = this.store;
    this.link?.update();
    if (view === "plan" || !missionId || connection.state !== "live") return;
    if (this.link?.missionId !== missionId && !this.#sitDown(missionId)) return;
    const address = `/viser/${encodeURIComponent(this.link?.scene ?? "")}/${shownTheme()}/`;
    if (!this.link?.scene || address === this.shown) return;
    this.shown = address;
    this.#load(address);
  }

  /** Whether the view can be there at all. @param {string} missionId */
  #sitDown(missionId) {
    if (this.shown === NO_WEBGL) return false;
    if (!document.createElement("canvas").getContext("webgl2")) {
      this.shown = NO_WEBGL;
      this.#say("No 3D in this browser", "It has no WebGL, or that is turned off. The plan shows the same and works without it.");
      return false;
    }
    this.link?.close();
    this.#say("Loading the 3D view", "The scene is being fetched.");
    this.link = new ViewLink(this.store, missionId, (reason) => {
      if (reason) this.#say("The 3D view is not available", `It cannot be opened: ${reason}. It is tried again; the plan works without it.`);
      this.update();
    });
    return true;
  }

  /** @param {string} address */
  async #load(address) {
    this.#say("Loading the 3D view", "The scene is being fetched.");
    try {
      await fetchChecked(address, { method: "HEAD" });
    } catch (error) {
      this.#say("The 3D view is not available", `${/** @type {Error} */ (error).message} The plan works without it.`);
      const again = document.createElement("button");
      again.type = "button";
      again.textContent = "Try again";
      again.addEventListener("click", () => this.#load(address));
      this.root.firstElementChild?.append(again);
      return;
    }
    if (address !== this.shown) return;
    const frame = document.createElement("iframe");
    frame.title = "The mission in 3D";
    frame.src = `${address}?hideViserLogo${shownTheme() === "dark" ? "&darkMode" : ""}`;
    const words = this.root.firstElementChild;
    frame.addEventListener("load", () => words?.remove()); // they lie over it until then
    this.root.prepend(frame);
  }

  /**
   * @param {string} title
   * @param {string} text
   */
  #say(title, text) {
    const words = document.createElement("div");
    words.className = "words";
    words.setAttribute("role", "status");
    const [strong, paragraph] = [document.createElement("strong"), document.createElement("p")];
    strong.textContent = title;
    paragraph.textContent = text;
    words.append(strong, paragraph);
    this.root.replaceChildren(words);
  }
}
