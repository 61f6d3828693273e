/** Areas that people draw: polygons by their corners. */

/** Whether a point lies in a polygon (even-odd rule). @param {[number, number][]} corners @param {number} x @param {number} y */
export function holds(corners, x, y) {
  return corners.reduce((inside, [ax, ay], k) => {
    const [bx, by] = corners[(k + 1) % corners.length];
    return (ay > y) !== (by > y) && x < ax + ((y - ay) / (by - ay)) * (bx - ax) ? !inside : inside;
  }, false);
}
