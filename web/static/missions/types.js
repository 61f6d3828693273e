/**
 * What the server tells of missions. Types only.
 *
 * @typedef {{mission_id: string, name: string, state: string, state_by: string, state_unix_s: number,
 *   created_unix_s: number, started_unix_s: number | null, duration_s: number, robots: number, explored_m2: number,
 *   tags: number, victims: number, heard_unix_s: number | null}} MissionRow
 * @typedef {{unix_s: number, clock_s: number, explored_m2: number, tags: number, victims: number}} Sample
 * @typedef {{mission: MissionRow, robots: {robot_id: string, distance_m: number, explored_m2: number}[],
 *   victims: Record<string, number>, alerts: Record<string, number>, progress: Sample[]}} Summary
 */
export {};
