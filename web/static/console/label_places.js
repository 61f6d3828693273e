/**
 * Where names stand on the plan, so that none covers another: greedy placement by rank over a few places around each
 * mark (Christensen, Marks and Shieber 1995), stable from frame to frame.
 */

/**
 * `x`, `y`, `width`, `height` and `gap` (from the middle of the mark to its edge) in pixels; a lower rank goes first.
 * `isForced`: stands even where it covers others. `isBold`: may cover marks, though no other name.
 * @typedef {{key: string, rank: number, x: number, y: number, width: number, height: number, gap: number,
 *   sides: string[], isForced?: boolean, isBold?: boolean}} Wish
 * @typedef {{key: string, x: number, y: number, half: number}} Block a mark that names stay off, half as wide as high
 * @typedef {{left: number, top: number, right: number, bottom: number, key: string}} Box
 * @typedef {{side: string, dx: number, dy: number}} Place from the middle of the mark to the middle of the name, pixels
 */

const CELL_PX = 48;
const LENIENT_PX = 3; // what stands may overlap by so much before it goes
const STRICT_PX = 3; // what comes anew keeps this far from others

/** Boxes by the cells that they lie in. */
class Boxes {
  /** @type {Map<number, Box[]>} */
  #cells = new Map();

  /** @param {Box} box @param {(cell: number) => boolean | void} visit true ends it */
  #some({ left, top, right, bottom }, visit) {
    for (let column = Math.floor(left / CELL_PX); column <= right / CELL_PX; column += 1) {
      for (let row = Math.floor(top / CELL_PX); row <= bottom / CELL_PX; row += 1) {
        if (visit(column * 0x100000 + row)) return true;
      }
    }
    return false;
  }

  /** @param {Box} box */
  add(box) {
    this.#some(box, (cell) => {
      const there = this.#cells.get(cell);
      if (there) there.push(box);
      else this.#cells.set(cell, [box]);
    });
  }

  /** Whether a box meets one of another key. @param {Box} box */
  meets(box) {
    return this.#some(box, (cell) => this.#cells.get(cell)?.some((other) => other.key !== box.key
      && other.left < box.right && box.left < other.right && other.top < box.bottom && box.top < other.bottom));
  }
}

/** @param {Wish} wish @param {string} side compass point, or "" for the middle @returns {Place} */
function placeAt({ width, height, gap }, side) {
  const [east, south] = [Number(side.includes("e")) - Number(side.includes("w")), Number(side.includes("s")) - Number(side.includes("n"))];
  const reach = east && south ? 0.6 * gap : gap;
  return { side, dx: east * (reach + width / 2), dy: south * (reach + height / 2) };
}

/** @param {Wish} wish @param {Place} place @param {number} grown @returns {Box} */
function boxAt({ key, x, y, width, height }, { dx, dy }, grown) {
  const [w, h] = [width / 2 + grown, height / 2 + grown];
  return { left: x + dx - w, right: x + dx + w, top: y + dy - h, bottom: y + dy + h, key };
}

export class LabelPlaces {
  /** Where each name stood last; one that was left out has no place. @type {Map<string, Place | null>} */
  #kept = new Map();
  #view = { left: 0, top: 0, right: 0, bottom: 0 };

  /**
   * Give each name a place, or none. What stood stays in place and goes before others of its rank, and what was left out
   * needs more room than what stands, so that nothing flickers while marks move.
   * @param {Wish[]} wishes
   * @param {Block[]} blocks
   * @param {Omit<Box, "key">} view what is seen: names stay inside, but for bold ones that have no room there
   * @returns {Map<string, Place>}
   */
  arrange(wishes, blocks, view) {
    this.#view = view;
    const [names, marks] = [new Boxes(), new Boxes()];
    for (const { key, x, y, half } of blocks) marks.add({ left: x - half, right: x + half, top: y - half, bottom: y + half, key });
    const last = this.#kept;
    this.#kept = new Map();
    /** @type {Map<string, Place>} */
    const placed = new Map();
    const order = [...wishes].sort((a, b) => a.rank - b.rank
      || Number(Boolean(last.get(b.key))) - Number(Boolean(last.get(a.key))) || (a.key < b.key ? -1 : 1));
    for (const wish of order) {
      const place = this.#find(wish, last.get(wish.key) ?? null, names, marks);
      this.#kept.set(wish.key, place);
      if (!place) continue;
      placed.set(wish.key, place);
      names.add(boxAt(wish, place, 0));
    }
    return placed;
  }

  /** @param {Wish} wish @param {Place | null} stood @param {Boxes} names @param {Boxes} marks @returns {Place | null} */
  #find(wish, stood, names, marks) {
    const sides = stood ? [stood.side, ...wish.sides.filter((side) => side !== stood.side)] : wish.sides;
    for (const isCareful of wish.isBold ? [true, false] : [true]) {
      for (const side of sides) {
        const place = placeAt(wish, side);
        const box = boxAt(wish, place, side === stood?.side ? -LENIENT_PX : STRICT_PX);
        if (!names.meets(box) && !(isCareful && (marks.meets(box) || !this.#isInView(box)))) return place;
      }
    }
    return wish.isForced ? placeAt(wish, sides[0]) : null;
  }

  /** @param {Box} box */
  #isInView({ left, top, right, bottom }) {
    const view = this.#view;
    return left >= view.left && right <= view.right && top >= view.top && bottom <= view.bottom;
  }
}
