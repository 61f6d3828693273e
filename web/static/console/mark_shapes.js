/** The elements that a mark on the plan is made of. */

const SVG = "http://www.w3.org/2000/svg";

/** @param {string} className */
function span(className) {
  const element = document.createElement("span");
  element.className = className;
  return element;
}

/** @param {string} robotId */
export function robotShape(robotId) {
  const arrow = document.createElementNS(SVG, "svg");
  arrow.setAttribute("viewBox", "0 0 32 32");
  arrow.setAttribute("class", "arrow");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", "M16 2.5 27 27.5Q27.4 28.9 26 28.3L16 23.6 6 28.3Q4.6 28.9 5 27.5Z");
  arrow.append(path);
  const name = span("name");
  name.textContent = robotId;
  return { sigma: span("sigma"), arrow, name };
}

export function victimShape() {
  return { sigma: span("sigma"), ...noteShape() };
}

export function noteShape() {
  const glyph = span("glyph");
  glyph.ariaHidden = "true";
  return { glyph, name: span("name") };
}
