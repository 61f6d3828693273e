/** Keeping this page on the phone, where the browser does that: a service worker needs HTTPS, or this very machine. */

import { html } from "../console/vendor.js";
import { say } from "./texts.js";

const SCOPES = ["/t", "/phone"];

/** Called when the page is loaded whole, so that a new version cannot mix with this one. */
export async function keepHere() {
  if (!("serviceWorker" in navigator)) return;
  navigator.storage?.persist?.(); // a browser may otherwise clear it after some days
  for (const scope of SCOPES) {
    const kept = await navigator.serviceWorker.register("/sw.js", { scope }).catch(() => null);
    if (!kept) continue;
    kept.waiting?.postMessage("go");
    kept.addEventListener("updatefound", () => {
      const coming = kept.installing;
      coming?.addEventListener("statechange", () => coming.state === "installed" && coming.postMessage("go"));
    });
  }
}

/** What this page cannot do where it came without HTTPS, and who can change that. */
export const WithoutHttps = () => !isSecureContext && html`<p class="soft">${say("no_https")}</p>`;
