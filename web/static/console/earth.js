/**
 * From the plan to the Earth: the same as server/geo (which names the sources), for what stands under the cursor.
 *
 * @typedef {{lat_deg: number, lon_deg: number, yaw_rad: number, height_m: number, sd_m: number, by: string,
 *   points: [number, number, number, number][]}} Georeference
 */

const A_M = 6378137, F = 1 / 298.257223563;
const E2 = F * (2 - F), E = Math.sqrt(E2), N = F / (2 - F), K0 = 0.9996;
const RADIUS_M = (A_M / (1 + N)) * (1 + N ** 2 / 4 + N ** 4 / 64);
const ALPHA = [
  N / 2 - (2 / 3) * N ** 2 + (5 / 16) * N ** 3 + (41 / 180) * N ** 4,
  (13 / 48) * N ** 2 - (3 / 5) * N ** 3 + (557 / 1440) * N ** 4,
  (61 / 240) * N ** 3 - (103 / 140) * N ** 4,
  (49561 / 161280) * N ** 4,
];
const BANDS = "CDEFGHJKLMNPQRSTUVWX", COLUMNS = ["STUVWXYZ", "ABCDEFGH", "JKLMNPQR"], ROWS = "ABCDEFGHJKLMNPQRSTUV";
const { sin, cos, tan, sinh, cosh, asinh, atanh, atan2, hypot, floor, sqrt, PI } = Math;
/** @param {number} degrees */
const rad = (degrees) => (degrees * PI) / 180;

/** @param {Georeference} frame @param {number} x_m @param {number} y_m @returns {[number, number]} latitude, longitude */
export function toEarth(frame, x_m, y_m) {
  const [lat0, lon0] = [rad(frame.lat_deg), rad(frame.lon_deg)];
  const [c, s] = [cos(frame.yaw_rad), sin(frame.yaw_rad)];
  const [east, north] = [c * x_m - s * y_m, s * x_m + c * y_m];
  const across = A_M / sqrt(1 - E2 * sin(lat0) ** 2);
  const out = (across + frame.height_m) * cos(lat0) - sin(lat0) * north;
  const [x, y] = [out * cos(lon0) - sin(lon0) * east, out * sin(lon0) + cos(lon0) * east];
  const z = (across * (1 - E2) + frame.height_m) * sin(lat0) + cos(lat0) * north;
  const flat = hypot(x, y), b = A_M * (1 - F);
  let reduced = atan2(z, flat * (1 - F)), lat = 0;
  for (let k = 0; k < 5; k++) {
    lat = atan2(z + (E2 / (1 - E2)) * b * sin(reduced) ** 3, flat - E2 * A_M * cos(reduced) ** 3);
    reduced = atan2((1 - F) * sin(lat), cos(lat));
  }
  return [(lat * 180) / PI, (atan2(y, x) * 180) / PI];
}

/** @param {number} lat_deg @param {number} lon */
function zoneOf(lat_deg, lon) {
  if (lat_deg >= 56 && lat_deg < 64 && lon >= 3 && lon < 12) return 32;
  if (lat_deg >= 72 && lon >= 0 && lon < 42) return lon < 9 ? 31 : lon < 21 ? 33 : lon < 33 ? 35 : 37;
  return floor((lon + 180) / 6) + 1;
}

/** The grid reference of the square metre, empty near the poles. @param {number} lat_deg @param {number} lon_deg */
export function toMgrs(lat_deg, lon_deg) {
  if (lat_deg < -80 || lat_deg > 84) return "";
  const zone = zoneOf(lat_deg, ((((lon_deg + 180) % 360) + 360) % 360) - 180);
  const lon = rad(((((lon_deg - (6 * zone - 183) + 180) % 360) + 360) % 360) - 180);
  const tau = tan(rad(lat_deg));
  const sigma = sinh(E * atanh((E * tau) / hypot(1, tau)));
  const conformal = tau * hypot(1, sigma) - sigma * hypot(1, tau);
  const xi = atan2(conformal, cos(lon)), eta = asinh(sin(lon) / hypot(conformal, cos(lon)));
  let [north, east] = [xi, eta];
  ALPHA.forEach((alpha, k) => {
    north += alpha * sin(2 * (k + 1) * xi) * cosh(2 * (k + 1) * eta);
    east += alpha * cos(2 * (k + 1) * xi) * sinh(2 * (k + 1) * eta);
  });
  const easting = floor(500_000 + K0 * RADIUS_M * east);
  const northing = floor(K0 * RADIUS_M * north + (lat_deg >= 0 ? 0 : 10_000_000));
  const band = BANDS[Math.min(floor((lat_deg + 80) / 8), BANDS.length - 1)];
  const row = (floor(northing / 100_000) + (zone % 2 ? 0 : 5)) % ROWS.length;
  /** @param {number} metres */
  const digits = (metres) => String(metres % 100_000).padStart(5, "0");
  return `${zone}${band} ${COLUMNS[zone % 3][floor(easting / 100_000) - 1]}${ROWS[row]} ${digits(easting)} ${digits(northing)}`;
}

/** Where north is on the plan, clockwise from up in degrees; to the right while nobody has said. @param {Georeference | null} frame */
export const northOf = (frame) => (frame === null ? 90 : (((frame.yaw_rad * 180) / PI) % 360 + 360) % 360);

/** What a person types for a place, as the server takes it: "48.13715, 11.57612" or a grid reference. @param {string} text */
export function placeTyped(text) {
  const found = /^\s*(-?\d+(?:\.\d+)?)\s*[,;\s]\s*(-?\d+(?:\.\d+)?)\s*$/.exec(text);
  return found ? { lat_deg: Number(found[1]), lon_deg: Number(found[2]) } : { grid: text.trim() };
}
