/** Sounds for what must not be missed, off until somebody turns them on here: alerts, MAYDAY, EVACUATE. */

import { chosenLook } from "../theme.js";
import { isOpen } from "./node_sensors.js";

/** @import {Store} from "./store.js" */

/**
 * Tones one after the other: hertz and seconds each, 0 Hz is a pause. No two are alike: EVACUATE is INSARAG's three
 * short ones, MAYDAY wails, an alert of another kind is one soft tone, an alarm two.
 * @type {Record<string, [number, number][]>}
 */
export const TONES = {
  evacuate: [[880, 0.5], [0, 0.25], [880, 0.5], [0, 0.25], [880, 0.5]],
  mayday: [[620, 0.35], [1240, 0.35], [620, 0.35], [1240, 0.35]],
  alarm: [[740, 0.16], [0, 0.08], [740, 0.16]],
  warning: [[440, 0.2]],
};
const AGAIN_MS = 8000; // MAYDAY and EVACUATE sound until somebody has acknowledged them

/** @type {AudioContext | null} */
let audio = null;

/** @param {string} name */
export function play(name) {
  if (chosenLook().sound !== "on") return;
  audio ??= new AudioContext();
  audio.resume(); // a page may sound only once somebody has pressed something
  let at = audio.currentTime + 0.02;
  for (const [hertz, seconds] of TONES[name]) {
    if (hertz) {
      const tone = audio.createOscillator();
      const volume = audio.createGain();
      tone.frequency.value = hertz;
      volume.gain.setValueAtTime(0, at);
      volume.gain.linearRampToValueAtTime(0.25, at + 0.02);
      volume.gain.setValueAtTime(0.25, at + seconds - 0.03);
      volume.gain.linearRampToValueAtTime(0, at + seconds);
      tone.connect(volume).connect(audio.destination);
      tone.start(at);
      tone.stop(at + seconds);
    }
    at += seconds;
  }
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
