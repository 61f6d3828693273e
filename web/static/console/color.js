/** One colour per robot, the same here and in 3D: stable by id, told apart by colour-blind eyes, never red. */

export const ROBOT_COLORS = [
  "#5cb8ff", "#ffb454", "#3ddbb0", "#f59bd0", "#f4e36b", "#a99bff",
  "#b5e36e", "#e5a78c", "#6fe3f2", "#d48bff", "#9fb8cc", "#e8dcc0",
];

/**
 * r1, r2, ... take the colours in order; any other name takes the one its letters (FNV-1a) fall on.
 * @param {string} robotId
 */
export function robotColor(robotId) {
  const number = /(\d{1,9})$/.exec(robotId);
  if (number && Number(number[1]) > 0) return ROBOT_COLORS[(Number(number[1]) - 1) % ROBOT_COLORS.length];
  let hash = 0x811c9dc5;
  for (const byte of new TextEncoder().encode(robotId)) hash = Math.imul(hash ^ byte, 0x01000193) >>> 0;
  return ROBOT_COLORS[hash % ROBOT_COLORS.length];
}
