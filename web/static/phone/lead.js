/** Where this phone is being led: kept over reloads, dropped when it is another mission's. */

import { ApiError, missionPath, request } from "../console/api.js";
import { changed, state } from "./state.js";

const TARGET = "waymark.target";

/** @param {unknown} error */
export const wordsOf = (error) => (error instanceof ApiError ? error.message : String(error));

/** @returns {{mission: string, to: string} | null} */
export function target() {
  try {
    const kept = JSON.parse(localStorage.getItem(TARGET) ?? "null");
    return kept && kept.mission === state.where?.mission_id ? kept : null;
  } catch {
    return null;
  }
}

export async function load() {
  if (!state.tagId) return;
  try {
    state.where = await request("GET", `/where/${encodeURIComponent(state.tagId)}${location.search}`);
    await findWay();
  } catch (error) {
    state.trouble = wordsOf(error);
  }
  changed();
}

export async function findWay() {
  const goal = target();
  state.route = null;
  if (!goal || !state.where) return;
  const query = new URLSearchParams({ from: state.tagId, to: goal.to });
  state.route = await request("GET", `${missionPath(goal.mission)}/routes?${query}`);
}

/** @param {string | null} to `victim:ID`, `tag:ID`, `note:ID`, or nowhere any more */
export async function lead(to) {
  state.trouble = "";
  if (to === null) localStorage.removeItem(TARGET);
  else localStorage.setItem(TARGET, JSON.stringify({ mission: state.where?.mission_id, to }));
  try {
    await findWay();
  } catch (error) {
    localStorage.removeItem(TARGET);
    state.trouble = wordsOf(error);
  }
  changed();
  scrollTo(0, 0);
}
