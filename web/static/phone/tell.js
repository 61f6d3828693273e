/** In the worker: what it writes into the page of a tag, from what the phone carries. As server/told.py. */

import { missionsWith, pocketOf } from "./carried.js";
import { all, get } from "./kept.js";
import { language, speakAs, SPOKEN } from "./language.js";
import { Roads } from "./roads.js";
import { whereIs, wordsOf } from "./where.js";

/** @import {Told} from "./told.js" */

/** @param {string} tagId @param {string | null} missionId only this one, if told @returns {Promise<Told | null>} null where the phone does not know the tag */
export async function tell(tagId, missionId) {
  const [items, spoken] = await Promise.all([all("pockets"), get("facts", SPOKEN)]);
  const [item] = missionsWith(items, tagId, missionId);
  if (!item) return null;
  speakAs(spoken?.value ?? "");
  const pocket = pocketOf(item);
  const where = whereIs(pocket, new Roads(pocket), tagId);
  return where && { language: language(), as_of_s: item.as_of_s, words: wordsOf(where), where };
}
