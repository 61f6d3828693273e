/** Sounds for what must not be missed, off until somebody turns them on here: alerts, MAYDAY, EVACUATE. */

import { chosenLook } from "../theme.js";
import { isOpen } from "./node_sensors.js";
import { AGAIN_MS, sound } from "./tones.js";

/** @import {Store} from "./store.js" */

/** @param {string} name of a signal */
export function play(name) {
  if (chosenLook().sound === "on") sound(name);
}

export class Sounds {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    /** @type {Set<string> | null} */
    this.known = null;
    this.calledAt = 0;
    this.missionId = "";
  }

  /** What is new since the last time sounds; what was there when the page came does not. */
  update() {
    const { missionId, live, connection } = this.store;
    if (connection.state !== "live") return;
    const open = [...live.alerts.values()].filter(isOpen);
    const known = this.missionId === missionId ? this.known : null;
    const fresh = known ? open.filter(({ alert_id }) => !known.has(alert_id)) : [];
    this.known = new Set(open.map(({ alert_id }) => alert_id));
    this.missionId = missionId ?? "";
    const me = this.store.me?.name;
    const isCalled = live.evacuation && !live.evacuation.acknowledged.some(({ name }) => name === me);
    const isMayday = open.some(({ kind }) => kind === "mayday");
    if (isCalled || isMayday) {
      if (Date.now() - this.calledAt < AGAIN_MS) return;
      this.calledAt = Date.now();
      play(isCalled ? "evacuate" : "mayday");
    } else {
      this.calledAt = 0;
      if (fresh.length) play(fresh.some(({ severity }) => severity === "alarm") ? "alarm" : "warning");
    }
  }
}
