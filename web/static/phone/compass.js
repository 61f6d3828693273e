/** The phone's compass: which way its top points, degrees from north. */

import { state } from "./state.js";

const LEAST_DEG = 3; // less is the hand
const EVERY_MS = 100;

let shown_ms = 0;

/** How the phone is turned on the plan, degrees from the plan's north; null where that cannot be told. */
export function headingOnPlan() {
  const north = state.roads?.north ?? null;
  return state.heading === null || north === null ? null : state.heading - north;
}

/** @param {() => void} onTurn called when the phone was turned */
export function watchCompass(onTurn) {
  const turn = (/** @type {number} */ heading) => {
    const far = state.heading === null ? 360 : Math.abs(((heading - state.heading + 540) % 360) - 180);
    if (far < LEAST_DEG || performance.now() - shown_ms < EVERY_MS) return;
    shown_ms = performance.now();
    state.heading = heading;
    onTurn();
  };
  addEventListener("deviceorientationabsolute", (event) => {
    const { alpha } = /** @type {DeviceOrientationEvent} */ (event);
    if (alpha !== null) turn((360 - alpha) % 360);
  });
  addEventListener("deviceorientation", (event) => {
    const heading = /** @type {any} */ (event).webkitCompassHeading; // iPhones
    if (typeof heading === "number") turn(heading);
  });
}

/** Whether this phone asks its owner before it tells a page how it is held (iPhones do). */
export const needsAsking = () => typeof (/** @type {any} */ (globalThis.DeviceOrientationEvent)?.requestPermission) === "function";

/** Ask for it; the browser allows that only at a touch. */
export async function askForSensors() {
  for (const kind of [globalThis.DeviceOrientationEvent, globalThis.DeviceMotionEvent]) {
    await /** @type {any} */ (kind)?.requestPermission?.().catch(() => "denied");
  }
}
