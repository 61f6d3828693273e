/** What active nodes measure: words for their readings and alerts, and the request that takes note of one. */

import { missionPath, request } from "./api.js";
import { fixed } from "./format.js";

/** @import {Alert, Node} from "./types.js" */
/** @import {Store} from "./store.js" */

/** What stands for a kind of alert, with its name: @type {Record<string, {glyph: string, label: string}>} */
export const ALERT_KINDS = {
  hot: { glyph: "°C", label: "Hot" },
  tilted: { glyph: "∠", label: "Knocked over" },
  pressure: { glyph: "hPa", label: "Pressure changed" },
  lost: { glyph: "…", label: "Lost" },
  stuck: { glyph: "⨯", label: "Stuck" },
  slipping: { glyph: "≈", label: "Wheels slip" },
  battery: { glyph: "▁", label: "Battery low" },
  magazine: { glyph: "0", label: "Few tags left" },
  agent: { glyph: "↻", label: "Agent" },
  tag: { glyph: "?", label: "Tag moved?" },
  victim: { glyph: "+", label: "Victim seen" },
  mayday: { glyph: "!", label: "MAYDAY" },
};

/** @param {Alert} alert */
export const isOpen = (alert) => alert.acknowledged_unix_s == null;

/**
 * Alerts of one tag or of all: those that nobody has taken note of first, alarms before warnings, then the newest.
 * @param {Store} store
 * @param {string} [tagId]
 */
export function alertsOf(store, tagId) {
  /** @param {Alert} alert */
  const urgency = (alert) => 2 * Number(isOpen(alert)) + Number(alert.severity === "alarm");
  return [...store.alerts.values()]
    .filter((alert) => tagId === undefined || alert.tag_id === tagId)
    .sort((a, b) => urgency(b) - urgency(a) || b.raised_unix_s - a.raised_unix_s);
}

/** The most urgent alert of each tag. @param {Store} store @returns {Map<string, Alert>} */
export function alertByTag(store) {
  return new Map(alertsOf(store).reverse().flatMap((alert) => (alert.tag_id ? [[alert.tag_id, alert]] : [])));
}

/** How a reading goes, in short. @param {number | null | undefined} perMin @param {number} still less than that is no change */
export function going(perMin, still) {
  if (perMin == null) return "";
  return Math.abs(perMin) < still ? ", steady" : ` ${perMin > 0 ? "↑" : "↓"} ${fixed(Math.abs(perMin), 1)}/min`;
}

/** @param {Node} node */
export function readings(node) {
  const tilt_deg = node.tilt_rad == null ? null : (180 * node.tilt_rad) / Math.PI;
  return [
    ["Temperature", node.temperature_c == null ? "" : `${fixed(node.temperature_c, 1)} °C${going(node.temperature_c_per_min, 0.1)}`],
    ["Pressure", node.pressure_hpa == null ? "" : `${fixed(node.pressure_hpa, 1)} hPa${going(node.pressure_hpa_per_min, 0.05)}`],
    ["Leans by", tilt_deg == null ? "" : `${fixed(tilt_deg, 0)}°`],
  ].filter(([, value]) => value);
}

/** What an alert is about, to be shown on the plan. @param {Alert} alert @returns {{kind: "robot" | "victim" | "tag", id: string} | null} */
export function subjectOf({ victim_id, tag_id, robot_id }) {
  if (victim_id) return { kind: "victim", id: victim_id };
  if (tag_id) return { kind: "tag", id: tag_id };
  return robot_id ? { kind: "robot", id: robot_id } : null;
}

/** The reading that an alert is about, in short. @param {Alert} alert @param {Node | undefined} node */
export function alarming(alert, node) {
  if (!node || !["hot", "tilted", "pressure"].includes(alert.kind)) return ALERT_KINDS[alert.kind]?.label ?? alert.kind;
  if (alert.kind === "hot") return `${fixed(node.temperature_c, 0)} °C`;
  if (alert.kind === "tilted") return "knocked over";
  return `${fixed(node.pressure_hpa, 0)} hPa`;
}

/** Somebody's MAYDAY was seen to. @param {Store} store @param {Alert} alert */
export async function endMayday(store, alert) {
  const name = alert.alert_id.slice("mayday:".length);
  try {
    await request("DELETE", `${missionPath(store.missionId ?? "")}/alerts/mayday/${encodeURIComponent(name)}`);
  } catch (error) {
    store.notify(`MAYDAY of ${name} was not ended. ${/** @type {Error} */ (error).message}`);
  }
}

/**
 * Take note of alerts, one after the other.
 * @param {Store} store
 * @param {Alert[]} alerts
 * @param {Event} event
 */
export async function acknowledge(store, alerts, event) {
  const button = /** @type {HTMLButtonElement} */ (event.currentTarget);
  button.disabled = true;
  for (const alert of alerts) {
    const path = `${missionPath(store.missionId ?? "")}/alerts/${encodeURIComponent(alert.alert_id)}/acknowledge`;
    try {
      await request("POST", path);
    } catch (error) {
      store.notify(`Not acknowledged: ${alert.text} ${/** @type {Error} */ (error).message}`);
      break;
    }
  }
  button.disabled = false;
  store.changed();
}
