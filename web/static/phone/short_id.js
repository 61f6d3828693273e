/** What people type for a tag: its id without look-alikes and a check character. As robots/tags/short_id.py does it. */

const ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ";
const LONGEST = 12;
/** @type {Record<string, string>} */
const LOOK_ALIKES = { O: "0", I: "1", L: "1", U: "V" };

/** The text without case, gaps and look-alikes; null where other characters are in it, or none. @param {string} text */
export function folded(text) {
  const plain = text.replace(/[\s_.–-]+/g, "").toUpperCase().replace(/[OILU]/g, (letter) => LOOK_ALIKES[letter]);
  return plain && [...plain].every((letter) => ALPHABET.includes(letter)) ? plain : null;
}

/** @param {number} value */
const doubled = (value) => (value < 16 ? value << 1 : (value << 1) ^ 0b100101);
/** @param {string} plain */
const sum = (plain) => [...plain].reduce((total, letter) => doubled(total) ^ ALPHABET.indexOf(letter), 1);
/** @param {string} plain */
const check = (plain) => ALPHABET[doubled(sum(plain))];

/** What is printed for a tag, null where its id is not for typing. @param {string} tagId @returns {string | null} */
export function shortId(tagId) {
  const plain = folded(tagId);
  if (plain === null || plain.length > LONGEST) return null;
  return [...(plain.match(/.{1,4}/g) ?? []), check(plain)].join("-");
}

/**
 * The tags that somebody means; where there is none, "unknown" if what was typed is right in itself.
 * @param {string} typed @param {Iterable<string>} tagIds
 * @returns {{tagIds: string[], trouble: "" | "mistyped" | "unknown"}}
 */
export function understood(typed, tagIds) {
  const exact = typed.trim();
  const plain = folded(typed);
  /** @param {string} tagId */
  const isMeant = (tagId) => {
    const own = plain && folded(tagId);
    return tagId === exact || (!!own && (plain === own || plain === own + check(own)));
  };
  const meant = [...new Set(tagIds)].filter(isMeant).sort();
  if (meant.length) return { tagIds: meant, trouble: "" };
  return { tagIds: [], trouble: plain && plain.length > 1 && sum(plain) === 0 ? "unknown" : "mistyped" };
}
