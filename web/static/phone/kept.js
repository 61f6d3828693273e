/** What the phone keeps over reloads: missions, reports that wait, and small facts, in IndexedDB. */

import "./early.js";

/** @typedef {"pockets" | "outbox" | "facts"} StoreName */

const early = /** @type {{kept$: import("./types.js").Early}} */ (/** @type {unknown} */ (globalThis)).kept$;
let opening = watched(early.first);

/** Missions as they were when the page began to be read. @returns {Promise<any[]>} */
export const firstPockets = () => early.pockets;

/** @param {Promise<IDBDatabase>} coming */
function watched(coming) {
  /** @type {Promise<IDBDatabase> | null} */
  let mine = coming;
  coming.then((database) => {
    database.onversionchange = () => database.close();
    database.onclose = () => (mine = null);
  }, () => (mine = null));
  return () => mine;
}

/** @returns {Promise<IDBDatabase>} opened anew where the browser has closed it or could not open it */
function open() {
  const there = opening();
  if (there) return there;
  const anew = early.open();
  opening = watched(anew);
  return anew;
}

/**
 * @template T
 * @param {StoreName} name
 * @param {IDBTransactionMode} mode
 * @param {(store: IDBObjectStore) => IDBRequest<T>} work
 * @returns {Promise<T>} once it is on the disk
 */
async function within(name, mode, work) {
  const transaction = (await open()).transaction(name, mode, { durability: "strict" });
  const asked = work(transaction.objectStore(name));
  await new Promise((resolve, reject) => {
    transaction.oncomplete = resolve;
    transaction.onerror = transaction.onabort = () => reject(transaction.error ?? asked.error);
  });
  return asked.result;
}

/** @param {StoreName} name @returns {Promise<any[]>} */
export const all = (name) => within(name, "readonly", (store) => store.getAll());

/** @param {StoreName} name @param {string} key @returns {Promise<any>} */
export const get = (name, key) => within(name, "readonly", (store) => store.get(key));

/** @param {StoreName} name @param {object} value */
export const put = (name, value) => within(name, "readwrite", (store) => store.put(value));

/** @param {StoreName} name @param {string} key */
export const drop = (name, key) => within(name, "readwrite", (store) => store.delete(key));

/** @param {StoreName} name @returns {Promise<string[]>} */
export const keys = (name) => within(name, "readonly", (store) => /** @type {IDBRequest<any>} */ (store.getAllKeys()));
