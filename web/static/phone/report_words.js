/** A report in one line. */

import { language } from "./language.js";
import { plain, say } from "./texts.js";

/** @import {Report} from "./outbox.js" */
/** @typedef {import("./texts.js").Key} Key */

/** @param {number} unix_s */
export const timeOf = (unix_s) => new Date(unix_s * 1000).toLocaleTimeString(language(), { hour: "2-digit", minute: "2-digit", hourCycle: "h23" });

/** What a report says, also for copying it by hand. @param {Report} report */
export function textOf({ kind, body, made_by, phone_unix_s, offset_s }) {
  const what = say(/** @type {Key} */ (kind === "note" ? `kind_${body.note}` : `kind_${kind}`));
  const counts = kind === "victim" ? `${say("live")} ${body.live}, ${say("dead")} ${body.dead}` : "";
  const time = timeOf(phone_unix_s + (offset_s ?? 0));
  return plain([`${what}${body.tag_id ? ` @ ${body.tag_id}` : ""}`, counts, body.text, `${made_by} ${time}`].filter(Boolean).join(" · "));
}
