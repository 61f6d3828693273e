/** Numbers and times as people read them. */

/** @param {number | null} age_s */
export function age(age_s) {
  if (age_s === null) return "never";
  if (age_s < 1.5) return "now";
  if (age_s < 60) return `${Math.floor(age_s)} s ago`;
  if (age_s < 3600) return `${Math.floor(age_s / 60)} min ago`;
  return `${Math.floor(age_s / 3600)} h ${Math.floor((age_s % 3600) / 60)} min ago`;
}

/** @param {number} unix_s */
export function timeOfDay(unix_s) {
  return new Date(unix_s * 1000).toLocaleTimeString("en-GB");
}

/**
 * The mission's clock: seconds since its start, or a time of day when a recording runs on its own calendar.
 * @param {number | null | undefined} clock_s
 */
export function missionClock(clock_s) {
  if (clock_s == null || !Number.isFinite(clock_s)) return "--:--:--";
  if (clock_s > 1e8) return new Date(clock_s * 1000).toISOString().slice(11, 19);
  const s = Math.max(0, Math.floor(clock_s));
  return [s / 3600, (s / 60) % 60, s % 60].map((part) => String(Math.floor(part)).padStart(2, "0")).join(":");
}

/**
 * @param {number | null | undefined} value
 * @param {number} digits
 */
export function fixed(value, digits) {
  return value == null || !Number.isFinite(value) ? "–" : value.toFixed(digits);
}

/** @param {number | null | undefined} metres */
export function metres(metres) {
  if (metres == null || !Number.isFinite(metres)) return "–";
  return metres >= 10000 ? `${(metres / 1000).toFixed(1)} km` : `${metres.toFixed(metres < 10 ? 1 : 0)} m`;
}

/** @param {number | null | undefined} share 0..1 */
export function percent(share) {
  return share == null || !Number.isFinite(share) ? "–" : `${Math.round(100 * share)} %`;
}

/**
 * Half axes of the 2-sigma ellipse and the direction of the longer one, counter-clockwise from x.
 * @param {number[] | null | undefined} covariance xx, xy, yy in square metres
 */
export function ellipse(covariance) {
  const [xx = 0, xy = 0, yy = 0] = covariance ?? [];
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major_m: 2 * Math.sqrt(Math.max(0, mean + spread)),
    minor_m: 2 * Math.sqrt(Math.max(0, mean - spread)),
    angle_rad: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}
