/** The door: log in with name and password, or join with a one-time link whose secret stands after the #. */

import { ApiError, request } from "../console/api.js";

const form = /** @type {HTMLFormElement} */ (document.querySelector("form"));
const name = /** @type {HTMLInputElement} */ (form.elements.namedItem("name"));
const password = /** @type {HTMLInputElement} */ (form.elements.namedItem("password"));
const button = /** @type {HTMLButtonElement} */ (form.querySelector("button"));

const isJoining = location.pathname === "/join";
const secret = location.hash.slice(1);

/** @param {string} id @param {string} text */
function write(id, text) {
  /** @type {HTMLElement} */ (document.getElementById(id)).textContent = text;
}

/** Where to go on: an address of ours, whatever the link says. */
function next() {
  const wanted = new URLSearchParams(location.search).get("next") ?? "/";
  const address = new URL(wanted, location.origin);
  return address.origin === location.origin ? address.pathname + address.search + address.hash : "/";
}

/** @param {SubmitEvent} event */
async function submit(event) {
  event.preventDefault();
  button.disabled = true;
  write("trouble", "");
  const words = { name: name.value.trim().replace(/\s+/g, " "), password: password.value };
  try {
    if (isJoining) await request("POST", "/join", { ...words, secret });
    else await request("POST", "/session", words);
    location.replace(next());
  } catch (error) {
    write("trouble", error instanceof ApiError ? error.message : String(error));
    const wrong = error instanceof ApiError && error.code === "name_taken" ? name : password;
    wrong.setAttribute("aria-invalid", "true");
    wrong.focus();
    button.disabled = false;
  }
}

document.title = `${isJoining ? "Join" : "Log in"} · Waymark`;
button.textContent = isJoining ? "Join" : "Log in";
password.autocomplete = isJoining ? "new-password" : "current-password";
if (isJoining) {
  password.minLength = 8;
  write("lead", "You were invited. Choose the name that others see, and a password of eight characters or more.");
  write("hint", "Have you joined before? Open this server's address and log in.");
  if (!secret) write("trouble", "This link is not whole: copy it with everything after the #.");
} else {
  write("lead", "Log in to see the missions of this server.");
  write("hint", "No account yet? Ask a commander for a link to join.");
}
form.addEventListener("submit", submit);
for (const input of [name, password]) input.addEventListener("input", () => input.removeAttribute("aria-invalid"));
/** @type {HTMLInputElement} */ (document.getElementById("show")).addEventListener("change", (event) => {
  password.type = /** @type {HTMLInputElement} */ (event.target).checked ? "text" : "password";
});
name.focus();
