/** One colour per robot, the same here and in 3D: stable by id, told apart by colour-blind eyes, never red. */

import { color } from "../theme.js";

const COLORS = 12;

/**
 * r1, r2, ... take the colours in order; any other name takes the one its letters (FNV-1a) fall on.
 * @param {string} robotId
 * @returns {string} the colour's name in the palette
 */
function nameOf(robotId) {
  const number = /(\d{1,9})$/.exec(robotId);
  if (number && Number(number[1]) > 0) return `robot-${1 + ((Number(number[1]) - 1) % COLORS)}`;
  let hash = 0x811c9dc5;
  for (const byte of new TextEncoder().encode(robotId)) hash = Math.imul(hash ^ byte, 0x01000193) >>> 0;
  return `robot-${1 + (hash % COLORS)}`;
}

/** As a style: it changes with the theme by itself. @param {string} robotId */
export const robotStyle = (robotId) => `var(--${nameOf(robotId)})`;

/** As a canvas wants it. @param {string} robotId */
export const robotColor = (robotId) => color(nameOf(robotId));
