/** Where moments lie on the time bar: the stretches in which nothing was recorded are left out. */

const PAUSE_S = 20; // as long without any change, and the mission stood still

export class Axis {
  /** @param {{begins_unix_s: number, ends_unix_s: number}[]} spans oldest first */
  constructor(spans) {
    /** What was recorded in one go, and where on the axis it begins. @type {{begins_s: number, ends_s: number, at_s: number}[]} */
    this.stretches = [];
    for (const { begins_unix_s, ends_unix_s } of spans) {
      const last = this.stretches.at(-1);
      if (last && begins_unix_s - last.ends_s <= PAUSE_S) last.ends_s = ends_unix_s;
      else this.stretches.push({ begins_s: begins_unix_s, ends_s: ends_unix_s, at_s: this.length_s });
    }
  }

  /** Seconds from one end to the other. */
  get length_s() {
    const last = this.stretches?.at(-1);
    return last ? last.at_s + last.ends_s - last.begins_s : 0;
  }

  /** The first moment, seconds since 1970. */
  get begins_s() {
    return this.stretches[0]?.begins_s ?? 0;
  }

  /** The last moment. */
  get ends_s() {
    return this.stretches.at(-1)?.ends_s ?? 0;
  }

  /** Where a moment lies, in seconds from the beginning of the axis. @param {number} unix_s */
  at(unix_s) {
    const { begins_s, ends_s, at_s } = this.stretches.findLast((each) => each.begins_s <= unix_s) ?? this.stretches[0]
      ?? { begins_s: 0, ends_s: 0, at_s: 0 };
    return at_s + Math.min(Math.max(0, unix_s - begins_s), ends_s - begins_s);
  }

  /** The moment at a place on the axis. @param {number} at_s */
  moment(at_s) {
    const stretch = this.stretches.findLast((each) => each.at_s <= at_s) ?? this.stretches[0];
    return stretch ? Math.min(stretch.begins_s + at_s - stretch.at_s, stretch.ends_s) : 0;
  }

  /** The moment so many recorded seconds on. @param {number} unix_s @param {number} seconds */
  on(unix_s, seconds) {
    return this.moment(Math.min(Math.max(0, this.at(unix_s) + seconds), this.length_s));
  }
}
