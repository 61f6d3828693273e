/** All that stands within the page: shows the answer that the server or the worker wrote into it; once that is painted, the rest is loaded. */

import { loaded } from "./loaded.js";
import { painted } from "./painted.js";
import { told } from "./told.js";

const page = /** @type {HTMLElement} */ (document.getElementById("page"));
const loading = [...page.children];

/** @param {string} name @param {string} className @param {string} textContent */
const element = (name, className, textContent) => Object.assign(document.createElement(name), { className, textContent });

async function begin() {
  const [how] = /** @type {PerformanceNavigationTiming[]} */ (performance.getEntriesByType("navigation"));
  if (told && how?.type === "navigate") { // whoever only looks again may be elsewhere by now
    const { title, text, warning } = told.words;
    document.documentElement.lang = told.language;
    document.title = `${title} · Waymark`;
    page.replaceChildren(element("h1", "", title), element("p", "where", text), ...(warning ? [element("p", "trouble", warning)] : []));
    await painted();
  }
  const phone = await loaded(() => import("./phone.js"), () => page.append(...loading));
  phone.begin();
}

begin();
