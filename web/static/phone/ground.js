/** The plan of a mission as cells: unknown, free, wall. Decoded once for each version of its picture. */

/** @import {Ground} from "./likelihood.js" */
/** @import {Pocket} from "./types.js" */

/** @type {{version: string, ground: Ground | null} | null} */
let decoded = null;

/** The cells of the plan; null while there is none or it is being decoded. @param {Pocket} pocket @returns {Ground | null} */
export function groundOf(pocket) {
  if (!pocket.map) return null;
  const version = `${pocket.mission_id} ${pocket.map.version}`;
  if (decoded?.version !== version) {
    decoded = { version, ground: decoded?.version.startsWith(`${pocket.mission_id} `) ? decoded.ground : null };
    decode(pocket.map).then((ground) => { if (decoded?.version === version) decoded.ground = ground; }, () => undefined);
  }
  return decoded.ground;
}

/** @param {import("./types.js").Plan} plan @returns {Promise<Ground>} */
async function decode({ png, width, height, origin_m, resolution_m }) {
  const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true }));
  context.drawImage(await createImageBitmap(new Blob([bytes], { type: "image/png" })), 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  const classes = new Uint8Array(width * height);
  for (let row = 0; row < height; row += 1) { // the picture's top row is the highest y
    for (let column = 0; column < width; column += 1) {
      const at = 4 * ((height - 1 - row) * width + column);
      classes[row * width + column] = data[at + 3] === 0 ? 0 : data[at] > 128 ? 1 : 2;
    }
  }
  return { classes, width, height, origin_m, resolution_m };
}
