/** What a victim's status is called and how it is drawn: shape and letter say it, colour only helps. */

export const VICTIM_STATUSES = /** @type {const} */ ({
  suspected: { label: "Suspected", glyph: "?" },
  confirmed: { label: "Confirmed", glyph: "+" },
  reached: { label: "Reached", glyph: "●" },
  extricated: { label: "Extricated", glyph: "✓" },
  dismissed: { label: "Dismissed", glyph: "×" },
});

/** @param {string} status @returns {{label: string, glyph: string}} */
export function statusOf(status) {
  return Object.hasOwn(VICTIM_STATUSES, status)
    ? VICTIM_STATUSES[/** @type {keyof typeof VICTIM_STATUSES} */ (status)]
    : { label: status, glyph: "?" };
}
