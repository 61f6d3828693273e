/** Which tag is meant by what was touched, scanned or typed; and going there. */

import { takeCode } from "./handover_view.js";
import { missions } from "./pockets.js";
import { reach, read } from "./reach.js";
import { understood } from "./short_id.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";
import { lead, touch } from "./touch.js";

/**
 * A tag's link, as a chip or a label has it.
 * @param {string} text
 * @returns {{tagId: string, host: string} | null}
 */
export function tagOfLink(text) {
  const parts = /^https?:\/\/([^/?#]+)\/t\/([^/?#]+)$/i.exec(text.trim());
  if (!parts) return null;
  try {
    return { host: parts[1].toLowerCase(), tagId: decodeURIComponent(parts[2]) };
  } catch {
    return null;
  }
}

/**
 * Go to the tag of a link. A link of another server is asked about: its tag may be a namesake.
 * @param {string} text
 * @param {number | null} [read_s] when the phone read it off the tag, by its clock
 */
export async function followLink(text, read_s = null) {
  const link = tagOfLink(text);
  if (link === null) return false;
  if (link.host === location.host) await touch(link.tagId, null, false, null, read_s);
  else ask({ foreign: link });
  return true;
}

/** @param {Partial<typeof state>} change something to be seen at the top of the page, in place of what was asked before */
export function ask(change) {
  changed({ trouble: "", choices: [], foreign: null, ...change });
  scrollTo(0, 0);
}

/** Go to the tag whose number somebody typed: one that the phone knows, else one that the server knows. @param {string} typed */
export async function goToTyped(typed) {
  if (await followLink(typed)) return;
  const here = understood(typed, missions().flatMap(({ tag_ids }) => tag_ids));
  const there = here.tagIds.length ? null : await read(`/where?${new URLSearchParams({ typed })}`);
  const found = there?.tag_ids ?? here.tagIds;
  if (found.length === 1) touch(found[0]);
  else if (found.length > 1) ask({ choices: found });
  else if (there) ask({ trouble: say(there.trouble === "unknown" ? "number_unknown" : "number_mistyped", { typed }) });
  else ask({ trouble: say(reach.inReach && reach.isLoggedOut ? "number_log_in" : "number_unknown_here", { typed }) });
}

/** Be led to the tag of this mission whose number somebody typed. @param {string} typed */
export function leadToTyped(typed) {
  const { tagIds, trouble } = understood(typed, (state.pocket?.tags ?? []).map(({ tag_id }) => tag_id));
  if (tagIds.length === 1) lead(`tag:${tagIds[0]}`);
  else if (tagIds.length > 1) ask({ trouble: say("number_of_several", { tags: tagIds.join(", ") }) });
  else ask({ trouble: say(!reach.inReach ? "number_unknown_here" : trouble === "unknown" ? "number_unknown" : "number_mistyped", { typed }) });
}

/** @param {string} text what a QR code says */
export async function goToScanned(text) {
  if (takeCode(text)) return; // reports of another phone, of which there is more to come
  state.scanning = false;
  if (!(await followLink(text, Date.now() / 1000))) ask({ trouble: say("not_a_tag", { text: text.slice(0, 60) }) });
}
