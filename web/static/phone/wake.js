/** Keeps the screen on where the browser can (HTTPS): while somebody is led, whose hands are not free to wake the phone. */

/** @type {WakeLockSentinel | null} */
let lock = null;
let isAsking = false;

/** Called again and again: the browser lets go of it by itself when the page is out of sight. @param {boolean} isLed */
export async function stayAwake(isLed) {
  if (!isLed) {
    const held = lock;
    lock = null;
    await held?.release();
    return;
  }
  if (isAsking || (lock && !lock.released) || document.visibilityState !== "visible" || !navigator.wakeLock) return;
  isAsking = true;
  lock = await navigator.wakeLock.request("screen").catch(() => null); // a phone that is low on power may refuse
  isAsking = false;
}
