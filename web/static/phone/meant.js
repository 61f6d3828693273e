/** Which tag is meant by what was touched, scanned or typed; and going there. */

import { ApiError, request } from "../console/api.js";
import { wordsOf } from "./lead.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

/** @param {string} tagId */
export function openTag(tagId) {
  location.assign(`/t/${encodeURIComponent(tagId)}`);
}

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

/** Go to the tag of a link. A link of another server is asked about: its tag may be a namesake. @param {string} text */
export function followLink(text) {
  const link = tagOfLink(text);
  if (link === null) return false;
  if (link.host === location.host) openTag(link.tagId);
  else ask({ foreign: link });
  return true;
}

/** @param {Partial<typeof state>} change something to be seen at the top of the page */
function ask(change) {
  changed({ trouble: "", choices: [], foreign: null, ...change });
  scrollTo(0, 0);
}

/** Go to the tag whose number somebody typed. @param {string} typed */
export async function goToTyped(typed) {
  if (followLink(typed)) return;
  try {
    const { tag_ids: found, trouble } = await request("GET", `/where?${new URLSearchParams({ typed })}`);
    if (found.length === 1) openTag(found[0]);
    else if (found.length > 1) ask({ choices: found });
    else ask({ trouble: say(trouble === "unknown" ? "number_unknown" : "number_mistyped", { typed }) });
  } catch (error) {
    if (error instanceof ApiError && error.status === 0) openTag(typed.trim());
    else ask({ trouble: wordsOf(error) });
  }
}

/** @param {string} text what a QR code says */
export function goToScanned(text) {
  state.scanning = false;
  if (!followLink(text)) ask({ trouble: say("not_a_tag", { text: text.slice(0, 60) }) });
}
