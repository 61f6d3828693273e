/**
 * Opens what the phone keeps, and asks for its missions, while the browser still reads the page and compiles its scripts.
 * In the page it is a script of its own at the top, and has run when a module imports it.
 */
{
  const STORES = { pockets: "mission_id", outbox: "id", facts: "name" };
  const page = /** @type {{kept$?: import("./types.js").Early}} */ (globalThis);

  /** @returns {Promise<IDBDatabase>} */
  const open = () => new Promise((resolve, reject) => {
    const asked = indexedDB.open("waymark", 1);
    asked.onupgradeneeded = () => {
      for (const [name, keyPath] of Object.entries(STORES)) asked.result.createObjectStore(name, { keyPath });
    };
    asked.onerror = () => reject(asked.error);
    asked.onsuccess = () => resolve(asked.result);
  });

  /** @param {IDBDatabase} database @returns {Promise<any[]>} */
  const pocketsOf = (database) => new Promise((resolve, reject) => {
    const asked = database.transaction("pockets").objectStore("pockets").getAll();
    asked.onsuccess = () => resolve(asked.result);
    asked.onerror = () => reject(asked.error);
  });

  if (!page.kept$) {
    const first = open();
    const pockets = first.then(pocketsOf);
    pockets.catch(() => undefined); // whoever needs them hears of it
    page.kept$ = { open, first, pockets };
  }
}
