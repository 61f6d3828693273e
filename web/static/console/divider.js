/** The border between plan and 3D view: dragged, or moved with the arrow keys. */

/** @import {Store} from "./store.js" */

const NARROWEST = 0.2;

/**
 * @param {HTMLElement} divider
 * @param {HTMLElement} stage
 * @param {Store} store
 */
export function attachDivider(divider, stage, store) {
  const show = () => {
    stage.style.setProperty("--split", `${100 * store.split}%`);
    divider.setAttribute("aria-valuenow", String(Math.round(100 * store.split)));
  };
  /** @param {number} split */
  const set = (split) => {
    store.split = Math.min(1 - NARROWEST, Math.max(NARROWEST, split));
    show();
  };
  divider.addEventListener("pointerdown", (event) => {
    divider.setPointerCapture(event.pointerId);
    stage.classList.add("dividing"); // else the 3D frame would swallow the movement
    event.preventDefault();
  });
  divider.addEventListener("pointermove", (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const { left, width } = stage.getBoundingClientRect();
    set((event.clientX - left) / width);
  });
  divider.addEventListener("lostpointercapture", () => {
    stage.classList.remove("dividing");
    store.keepPreferences();
  });
  divider.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -0.03, ArrowRight: 0.03 }[event.key];
    if (!step) return;
    event.preventDefault();
    set(store.split + step);
    store.keepPreferences();
  });
  show();
}
