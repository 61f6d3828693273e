/** What the phone carries of a mission (GET /api/v1/missions/{m}/pocket), and what it makes of it. */

/** @typedef {"sound" | "moved" | "cloned" | "doubtful"} TagState */
/** @typedef {{tag_id: string, x_m: number, y_m: number, sd_m: number, state: TagState, notice: string, place_kind?: string}} PocketTag */
/** Numbers of two tags, length in cm, points x, y, x, y, ... in cm, by how much more it counts as it is narrow, its narrowest width,
 *  0 where not known, in cm, and how long it was to somebody who walked it, 0 where a robot drove, in cm.
 *  @typedef {[number, number, number, number[], number, number, number]} PocketWay */
/** A tag in sight, and centimetres from there. @typedef {[string, number]} End */
/** @typedef {{victim_id: string, x_m: number, y_m: number, sd_m: number, status: string, confidence: number, live: number | null,
 *   dead: number | null, triage: string, note: string, merged_into: string | null, by: string, ends: End[]}} PocketVictim */
/** @typedef {{annotation_id: string, kind: string, text: string, x_m: number | null, y_m: number | null, tag_id: string | null,
 *   area_m: [number, number][], by: string, changed_unix_s: number, ends: End[]}} PocketNote */
/** @typedef {{version: number, width: number, height: number, resolution_m: number, origin_m: [number, number], png: string}} Plan */
/** Where the first robot started. @typedef {{x_m: number, y_m: number, tag_id: string | null, ends: End[]}} Base */
/** The radio of the mission's nodes. @typedef {{power_at_1m_dbm: number, path_loss_exponent: number, distances_m: number[], sds_db: number[],
 *   fading_sd_db: number, reach_m: number, gain_sd_db: number, exponent_sd: number, wall_db: number}} Radio */
/** @typedef {{ordered: boolean, by: string, since_unix_s: number, acknowledged: {name: string}[]}} Evacuation */
/** @typedef {{mission_id: string, mission_name: string, state: string, created_unix_s: number, evacuation: Evacuation | null,
 *   radio: Radio, x_axis_deg: number | null, map: Plan | null, tags: PocketTag[], ways: PocketWay[], victims: PocketVictim[], notes: PocketNote[], base: Base | null,
 *   left_out: Record<string, number>, parts: Record<string, string>}} Pocket */

/** A piece of a route. @typedef {{from_tag: string, to_tag: string | null, distance_m: number, bearing_deg: number, text: string,
 *   uncertain: boolean, hazards: string[], points_m: [number, number][]}} Step */
/** `goal`: what it leads to, in words. @typedef {{goal: string, distance_m: number, legs: Step[], last: Step | null}} Route */
/** @typedef {{victim_id: string, status: string, distance_m: number, reachable: boolean}} NearVictim */
/** @typedef {{mission_id: string, mission_name: string, tag_id: string, sd_m: number, state: TagState, notice: string, text: string,
 *   victims: NearVictim[]}} Where */

export {};
