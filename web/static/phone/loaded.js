const RETRY_MS = 3000;

/**
 * What is imported later, once it is here, however long the server is out of reach.
 * @template T
 * @param {() => Promise<T>} load
 * @param {() => void} failed called after each try that came to nothing
 */
export async function loaded(load, failed) {
  for (;;) {
    try {
      return await load();
    } catch {
      failed();
      await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
    }
  }
}
