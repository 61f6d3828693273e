/**
 * The values of the board, as they come over the wire. Types only.
 *
 * @typedef {{mission_id: string, name: string, state: string, created_unix_s: number, clock_s?: number | null,
 *   stopped_all?: boolean, state_by?: string, state_unix_s?: number, ran_s?: number}} Mission
 * @typedef {{sector_id: string, name: string, area_m: [number, number][], size_m2: number, status: string, robots: string[],
 *   team: string, note: string, period: number | null, by: string, changed_unix_s: number, worksite?: Worksite | null}} Sector
 * @typedef {{worksite_id: string, hazards: string, triage: string | null, is_complete: boolean, visits: Visit[],
 *   ratings?: Rating[], clearances?: Clearance[]}} Worksite
 * @typedef {{team: string, risk: "low" | "moderate" | "high", entry: "left" | "right" | "above" | "below" | null, rated_unix_s: number}} Rating
 * @typedef {{team: string, found: "clear" | "deceased", cleared_unix_s: number}} Clearance
 * @typedef {{team: string, level: number | null, entered_unix_s: number, left_unix_s: number | null, is_finished: boolean,
 *   parts: string}} Visit
 * @typedef {{number: number, commander: string, objectives: string, begun_unix_s: number, ended_unix_s: number | null}} Period
 * @typedef {{photo_id: string, width: number, height: number, text: string, victim_id: string | null,
 *   annotation_id: string | null, tag_id: string | null, x_m: number | null, y_m: number | null, by: string,
 *   taken_unix_s: number | null, created_unix_s: number, address: string, thumbnail: string}} Photo
 * @typedef {{robot_id: string, x_m: number, y_m: number, yaw_rad: number, covariance: number[], stamp_s: number,
 *   heard_unix_s: number | null, activity: string, reason: string, battery: number | null, tags_left: number | null,
 *   agent: string, slam?: string, methods?: Record<string, string>, stopped: boolean, link: "live" | "late" | "lost", slipping: boolean, located: boolean,
 *   explored_m2: number, distance_m: number, goal_m: [number, number] | null, path_m: [number, number][],
 *   speed_mps: number | null, stop_heard?: boolean, agent_down?: boolean}} Robot
 * @typedef {{robot_id: string, frontiers: {x_m: number, y_m: number, length_m: number, worth_m: number,
 *   chosen: boolean}[]}} Frontiers
 * @typedef {{order_id: string, kind: string, by: string, issued_unix_s: number, x_m: number | null, y_m: number | null,
 *   explore: string, coordinate: string, communication: string, state: "issued" | "delivered" | "done" | "failed",
 *   text: string}} Order
 * @typedef {{robot_id: string, orders: Order[]}} Orders
 * @typedef {{explore: string[], coordinate: string[], communication: string[]}} Methods
 * @typedef {{robot_id: string, points_m: [number, number][]}} Trail
 * @typedef {{tag_id: string, x_m: number, y_m: number, covariance: number[], sightings: number,
 *   robots: string[], state?: "sound" | "moved" | "cloned" | "doubtful", notice?: string}} Tag
 * @typedef {{tag_id: string, temperature_c: number | null, pressure_hpa: number | null, tilt_rad: number | null,
 *   heard_unix_s: number, robot_id: string, temperature_c_per_min?: number | null,
 *   pressure_hpa_per_min?: number | null}} Node
 * @typedef {{alert_id: string, kind: string, text: string, robot_id: string | null, tag_id: string | null,
 *   victim_id: string | null, severity: "info" | "warning" | "alarm", raised_unix_s: number, over_unix_s: number | null,
 *   acknowledged_by: string, acknowledged_unix_s: number | null}} Alert
 * @typedef {{victim_id: string, x_m: number, y_m: number, covariance: number[], confidence: number, status: string,
 *   sightings: number, robots: string[], note: string, team: string, live: number | null, dead: number | null,
 *   live_before?: number[], dead_before?: number[], start: Start, triage: string, place_m: [number, number] | null, merged_into: string | null, tag_id: string | null, by: string,
 *   changed_unix_s: number | null}} Victim
 * @typedef {{walks: boolean | null, breaths_per_min: number | null, breathes_after_airway: boolean | null,
 *   pulse: boolean | null, obeys: boolean | null}} Start
 * @typedef {{annotation_id?: string, kind: string, text: string, x_m?: number | null, y_m?: number | null,
 *   tag_id?: string | null, area_m: [number, number][], by: string, changed_unix_s: number}} Annotation
 * @typedef {{version: number, width: number, height: number, resolution_m: number, origin_m: [number, number], explored_m2: number,
 *   png: string, source?: string, by?: string}} MapInfo
 * @typedef {{state: "none" | "solving" | "ready" | "failed", reason: string, asked_unix_s: number | null,
 *   robots_done: number, robots_total: number, solved_unix_s: number | null, explored_m2: number | null,
 *   map: MapInfo | null, as_of: {robot_id: string, seq: number, stamp_s: number, distance_m: number}[],
 *   left_out: {robot_id: string, reason: string}[]}} BestMapState
 * @typedef {Trail & {located: boolean, x_m: number, y_m: number, yaw_rad: number}} BestRobot
 * @typedef {BestMapState & {is_current: boolean, robots: BestRobot[], tags: Tag[], links: [string, string][],
 *   victims: {victim_id: string, x_m: number, y_m: number, covariance: number[]}[]}} BestMapContent
 * @typedef {{event_id: number, unix_s: number, kind: string, text: string, robot_id?: string | null,
 *   severity: "info" | "warning" | "alarm"}} MissionEvent
 * @typedef {{ordered: boolean, by: string, since_unix_s: number, acknowledged: {name: string, unix_s: number}[]}} Evacuation
 * @typedef {{name: string, role: string, since_unix_s: number, pages: number}} Person
 * @typedef {{name: string, role: string, login: boolean}} Me
 * @typedef {"loading" | "live" | "reconnecting" | "stale" | "none" | "failed"} ConnectionState
 */
export {};
