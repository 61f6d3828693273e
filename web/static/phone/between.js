/**
 * Where this phone is between tags: steps counted and the compass followed from the tag read last, with an error that grows.
 */

import { headingOnPlan } from "./compass.js";
import { state } from "./state.js";

/** North and west of the mission's frame, metres; `sd_m` along each axis. @typedef {{x_m: number, y_m: number, sd_m: number, steps: number}} Place */

const STEP_M = 0.7; // of somebody in gear, Weinberg 2002 gives 0.6 to 0.8
const STEP_SD = 0.1; // share of the way: a step's length 0.08 (Weinberg's range), steps missed 0.06
const HEADING_SD = 0.2; // rad: 7 degrees of a compass among steel, 9 of how the phone is held
const LONG_STEP = 1.3; // nobody comes further; as server/mission/locating.py
const AT_TAG_M = 0.5; // who touches a tag stands beside it
const GRAVITY = 9.81;
const PEAK = 1.2; // m/s2 above rest that a step makes
const REST = 0.3;
const SHORTEST_MS = 280; // between steps

/** Tells steps from the acceleration of a phone: a peak after a rest, not sooner than people walk. */
export class StepCounter {
  constructor() {
    this.smooth = GRAVITY;
    this.isUp = false;
    this.last_ms = -Infinity;
  }

  /** @param {number} x @param {number} y @param {number} z m/s2, gravity included @param {number} now_ms @returns {boolean} whether this ends a step */
  feel(x, y, z, now_ms) {
    this.smooth += 0.35 * (Math.hypot(x, y, z) - this.smooth); // what shakes faster than a step does not count
    const over = this.smooth - GRAVITY;
    if (over < REST) this.isUp = false;
    if (over < PEAK || this.isUp || now_ms - this.last_ms < SHORTEST_MS) return false;
    this.isUp = true;
    this.last_ms = now_ms;
    return true;
  }
}

/** A way walked from a tag on. */
export class Walk {
  /** @param {{x_m: number, y_m: number, sd_m: number}} tag */
  constructor(tag) {
    this.start = tag;
    this.x_m = tag.x_m;
    this.y_m = tag.y_m;
    this.steps = 0;
    this.along_m = 0;
    this.blind_m = 0;
  }

  /** @param {number | null} heading degrees from the plan's north; null where that is not known */
  step(heading) {
    this.steps += 1;
    if (heading === null) {
      this.blind_m += STEP_M;
      return;
    }
    const angle = (heading * Math.PI) / 180;
    this.x_m += STEP_M * Math.cos(angle);
    this.y_m -= STEP_M * Math.sin(angle);
    this.along_m += STEP_M;
  }

  /**
   * Errors of a heading and of a step's length last, so they grow with the way, not with its root; one is across it, the other along,
   * and half of the variance of both is that of either axis. @returns {Place}
   */
  get place() {
    const whole_m = Math.hypot(this.start.sd_m, STEP_SD * this.along_m, HEADING_SD * this.along_m, this.blind_m);
    return { x_m: this.x_m, y_m: this.y_m, sd_m: Math.hypot(whole_m / Math.SQRT2, AT_TAG_M), steps: this.steps };
  }
}

const counter = new StepCounter();
let feels = false; // this phone tells how it is shaken
/** @type {{tagId: string, walk: Walk} | null} */
let now = null;

/** Where the phone is by its own steps; null where it cannot tell. @returns {Place | null} */
export function placeNow() {
  return now && now.tagId === state.tagId && now.walk.steps ? now.walk.place : null;
}

/** Where the phone was for certain, and how far it can have come; null where steps are not counted. @returns {import("./likelihood.js").Since | null} */
export function sinceTag() {
  if (!now || now.tagId !== state.tagId || !feels) return null;
  const { start, steps } = now.walk;
  return { x_m: start.x_m, y_m: start.y_m, sd_m: Math.hypot(start.sd_m / Math.SQRT2, AT_TAG_M), at_most_m: LONG_STEP * STEP_M * steps };
}

/** How far the phone has come from a tag by its own steps, m; null where it did not count them from there. @param {string} tagId */
export function walkedFrom(tagId) {
  return now && now.tagId === tagId && feels ? Math.round(10 * STEP_M * now.walk.steps) / 10 : null;
}

/** Begin at the tag that was read. */
export function begin() {
  const tag = state.roads?.tags[state.roads.numbers.get(state.tagId) ?? -1];
  now = tag ? { tagId: state.tagId, walk: new Walk(tag) } : null;
}

/** Count steps from now on. @param {() => void} onStep */
export function countSteps(onStep) {
  addEventListener("devicemotion", ({ accelerationIncludingGravity: felt }) => {
    if (!felt || felt.x === null || felt.y === null || felt.z === null) return;
    feels = true;
    if (!now || !counter.feel(felt.x, felt.y, felt.z, performance.now())) return;
    now.walk.step(headingOnPlan());
    onStep();
  });
}
