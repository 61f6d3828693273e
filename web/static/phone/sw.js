/**
 * Keeps the phone's page on the phone. The server puts VERSION and FILES (address -> SHA-256) before this text, so that it
 * changes whenever one of them does. A version is kept whole or not at all, and an old one goes only with the next.
 */

import { here } from "./address.js";
import { tell } from "./tell.js";

const LONGEST_MS = 1000;
const TOLD = '<script type="application/json" id="told">';

const sw = /** @type {any} */ (self);
/** @type {Record<string, string>} */
const FILES = sw.FILES;
const PAGE = "/phone";
const MINE = `waymark ${sw.registration.scope} `; // each scope has its own: one may be updated while the other is not
const NAME = MINE + sw.VERSION;

sw.addEventListener("install", (/** @type {any} */ event) => event.waitUntil(keep()));
sw.addEventListener("activate", (/** @type {any} */ event) => event.waitUntil(forget()));
sw.addEventListener("message", (/** @type {MessageEvent} */ event) => {
  if (event.data === "go") sw.skipWaiting(); // said by a page that is loaded whole: it will not mix versions
});
sw.addEventListener("fetch", (/** @type {any} */ event) => {
  /** @type {Request} */
  const request = event.request;
  const { origin, pathname } = new URL(request.url);
  if (request.method !== "GET" || origin !== sw.location.origin) return;
  if (request.mode === "navigate" && /^\/(phone|t)(\/|$)/.test(pathname)) event.respondWith(pageAt(request));
  else if (pathname in FILES) event.respondWith(find(pathname, request));
});

async function keep() {
  const cache = await caches.open(NAME);
  if ((await cache.keys()).length === Object.keys(FILES).length) return;
  const found = await Promise.all(Object.entries(FILES).map(async ([address, hash]) => {
    const response = await fetch(address, { cache: "no-cache" });
    if (!response.ok || (await hashOf(await response.clone().arrayBuffer())) !== hash) throw new Error(`${address} has changed`);
    return { address, response };
  }));
  await Promise.all(found.map(({ address, response }) => cache.put(address, response)));
}

async function forget() {
  for (const name of await caches.keys()) if (name.startsWith(MINE) && name !== NAME) await caches.delete(name);
  await sw.clients.claim();
}

/** The page with what there is to say of its tag written into it, as the server does: as data, which no text in it can end. @param {Request} request */
async function pageAt(request) {
  const [tagId, mission] = here(new URL(request.url));
  const [page, told] = await Promise.all([kept(PAGE), tagId && inTime(tell(tagId, mission))]);
  if (!page || !told) return page ?? fetch(request);
  const [before, after] = (await page.text()).split(TOLD);
  const headers = new Headers(page.headers);
  for (const name of ["Content-Encoding", "Content-Length", "ETag"]) headers.delete(name);
  return new Response(before + TOLD + JSON.stringify(told).replaceAll("<", "\\u003c") + after, { headers });
}

/** A storage that hangs must not keep the page from opening. @template T @param {Promise<T>} coming @returns {Promise<T | null>} */
const inTime = (coming) => Promise.race([coming.catch(() => null), new Promise((resolve) => setTimeout(() => resolve(null), LONGEST_MS))]);

/** @param {string} address */
const kept = (address) => caches.match(address, { cacheName: NAME });

/** @param {string} address @param {Request} request */
async function find(address, request) {
  return (await kept(address)) ?? fetch(request);
}

/** @param {ArrayBuffer} body */
async function hashOf(body) {
  const digest = await crypto.subtle.digest("SHA-256", body);
  return [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
