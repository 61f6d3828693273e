/** What console and phone know alike of notes: their kinds, and ids that either makes. */

/** @type {Record<string, {label: string, glyph: string, color: string}>} */
export const NOTE_KINDS = {
  hazard: { label: "Hazard", glyph: "!", color: "warn" },
  note: { label: "Note", glyph: "i", color: "note" },
  searched: { label: "Searched", glyph: "✓", color: "cleared" },
  exit: { label: "Exit", glyph: "⇥", color: "good" },
  victim: { label: "Victim", glyph: "+", color: "danger" },
};

/** A random id (UUID 4), also where the page has no secure context, as over plain HTTP in a field network. */
export function newId() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = (bytes[6] & 0x0f) | 0x40;
  bytes[8] = (bytes[8] & 0x3f) | 0x80;
  const hex = [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  return [hex.slice(0, 8), hex.slice(8, 12), hex.slice(12, 16), hex.slice(16, 20), hex.slice(20)].join("-");
}
