/** What the phone keeps over reloads: missions, reports that wait, and small facts, in IndexedDB. */

/** @typedef {"pockets" | "outbox" | "facts"} StoreName */

const STORES = { pockets: "mission_id", outbox: "id", facts: "name" };

/** @type {Promise<IDBDatabase> | null} */
let database = null;

/** @returns {Promise<IDBDatabase>} opened anew where the browser has closed it or could not open it */
function open() {
  database ??= opened().catch((error) => {
    database = null;
    throw error;
  });
  return database;
}

/** @returns {Promise<IDBDatabase>} */
const opened = () => new Promise((resolve, reject) => {
  const asked = indexedDB.open("waymark", 1);
  asked.onupgradeneeded = () => {
    for (const [name, keyPath] of Object.entries(STORES)) asked.result.createObjectStore(name, { keyPath });
  };
  asked.onerror = () => reject(asked.error);
  asked.onsuccess = () => {
    asked.result.onversionchange = () => asked.result.close();
    asked.result.onclose = () => (database = null);
    resolve(asked.result);
  };
});

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
