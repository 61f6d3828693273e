/** A page that is looked at again much later: it says when its owner was at the tag, not that they are there. */

import { say } from "./texts.js";
import { lastTag } from "./touch.js";

/** @import {Where} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

const LONG_S = 900; // who works at a tag for longer touches it again
const SET_BACK_S = -60;
const KINDS = ["doorway", "corridor", "room", "open_area"];

/** Where one is, or was. @param {Where} where */
export function whereText({ tag_id: tag, text }) {
  const last = lastTag();
  const age_s = last?.tag === tag ? Date.now() / 1000 - last.since_s : 0;
  if (age_s > SET_BACK_S && age_s < LONG_S) return text;
  const places = KINDS.map((kind) => say("you_are_in", { tag, place: say(/** @type {Key} */ (`in_${kind}`)) }));
  const begin = [say("you_are_at", { tag }), ...places].find((words) => text.startsWith(words)) ?? "";
  return `${say("you_were_at", { tag, when: when(age_s) })}${text.slice(begin.length)}`;
}

/** @param {number} age_s */
function when(age_s) {
  if (age_s <= SET_BACK_S) return say("ago_unknown");
  if (age_s < 5400) return say("ago_minutes", { n: Math.round(age_s / 60) });
  return age_s < 172_800 ? say("ago_hours", { n: Math.round(age_s / 3600) }) : say("ago_days", { n: Math.round(age_s / 86_400) });
}
