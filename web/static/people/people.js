/** Who may do what: accounts, invitations, robots' tokens, and the log of changes. For commanders. */

import { ApiError, request } from "../console/api.js";
import { html, render } from "../console/vendor.js";

/** @typedef {{account_id: string, name: string, role: string, created_unix_s: number, disabled: boolean}} Account */
/** @typedef {{token_id: string, label: string, mission_id: string | null, robot_id: string | null, by: string,
 *   created_unix_s: number, revoked_unix_s: number | null}} Token */
/** @typedef {{audit_id: number, unix_s: number, mission_id: string | null, by: string, role: string, action: string,
 *   subject: string}} Entry */

const ROLES = ["viewer", "responder", "operator", "commander"];
const MAY = "A viewer looks; a responder also reports and can STOP; an operator commands robots; a commander does everything.";
const PAGE = 100;

const state = {
  /** @type {Account[]} */ accounts: [],
  /** @type {Token[]} */ tokens: [],
  /** @type {Entry[]} */ entries: [],
  /** @type {{mission_id: string, name: string}[]} */ missions: [],
  /** What is told once. @type {{title: string, text: string} | null} */ secret: null,
  trouble: "",
  more: false,
};

const page = /** @type {HTMLElement} */ (document.getElementById("page"));

/** @param {string} text */
function announce(text) {
  /** @type {HTMLElement} */ (document.getElementById("announcer")).textContent = text;
}

/** Do something, say what went wrong, and show how things stand now. @param {() => Promise<void>} work */
async function act(work) {
  state.trouble = "";
  try {
    await work();
    await load();
  } catch (error) {
    state.trouble = error instanceof ApiError ? error.message : String(error);
    announce(state.trouble);
  }
  show();
}

async function load() {
  const [accounts, tokens, audit, missions] = await Promise.all(
    ["/accounts", "/robot-tokens", `/audit?limit=${PAGE}`, "/missions"].map((path) => request("GET", path)));
  Object.assign(state, { accounts: accounts.accounts, tokens: tokens.tokens, entries: audit.entries,
    missions: missions.missions, more: audit.entries.length === PAGE });
}

async function loadOlder() {
  const before = state.entries.at(-1)?.audit_id ?? 1;
  const { entries } = await request("GET", `/audit?limit=${PAGE}&before=${before}`);
  state.entries = [...state.entries, ...entries];
  state.more = entries.length === PAGE;
  show();
}

/** @param {number} unix_s */
const when = (unix_s) => new Date(unix_s * 1000).toLocaleString(undefined, { dateStyle: "short", timeStyle: "medium" });

/** @param {SubmitEvent} event */
function invite(event) {
  event.preventDefault();
  const role = new FormData(/** @type {HTMLFormElement} */ (event.target)).get("role");
  act(async () => {
    const { path } = await request("POST", "/links", { role });
    state.secret = { title: `Send this to one person: within a day it makes an account as ${role}.`, text: location.origin + path };
  });
}

/** @param {SubmitEvent} event */
function makeToken(event) {
  event.preventDefault();
  const words = new FormData(/** @type {HTMLFormElement} */ (event.target));
  act(async () => {
    const made = await request("POST", "/robot-tokens", {
      label: String(words.get("label")).trim(), mission_id: words.get("mission") || null, robot_id: words.get("robot") || null });
    state.secret = { title: `The token of ${made.label}. It is told only now: put it into the robot as WAYMARK_TOKEN.`, text: made.token };
  });
}

/** @param {Account} account @param {Record<string, unknown>} change */
const changeAccount = (account, change) => act(() => request("PATCH", `/accounts/${account.account_id}`, change));

/** @param {Account} account */
function newPassword(account) {
  const password = prompt(`A new password for ${account.name} (eight characters or more):`);
  if (password) changeAccount(account, { password });
}

function Secret() {
  const { secret } = state;
  if (!secret) return null;
  const copy = async () => {
    await navigator.clipboard?.writeText(secret.text).then(() => announce("Copied"), () => announce("Copy it by hand"));
  };
  return html`<div class="secret" role="status"><b>${secret.title}</b><code>${secret.text}</code>
    <div><button type="button" onClick=${copy}>Copy</button>
      <button type="button" onClick=${() => { state.secret = null; show(); }}>Done</button></div></div>`;
}

function People() {
  return html`<section aria-labelledby="people"><h2 id="people">People</h2><p class="about">${MAY}</p>
    <div class="table"><table><thead><tr><th>Name</th><th>Role</th><th>Since</th><th></th></tr></thead><tbody>
      ${state.accounts.map((account) => html`<tr key=${account.account_id} class=${account.disabled ? "off" : ""}>
        <td>${account.name}${account.disabled && " (shut out)"}</td>
        <td><select aria-label=${`Role of ${account.name}`} value=${account.role}
          onChange=${(/** @type {any} */ event) => changeAccount(account, { role: event.currentTarget.value })}>
          ${ROLES.map((role) => html`<option selected=${role === account.role}>${role}</option>`)}</select></td>
        <td>${when(account.created_unix_s)}</td>
        <td><button type="button" onClick=${() => newPassword(account)}>New password</button>${" "}
          <button type="button" class=${account.disabled ? "" : "danger"}
            onClick=${() => changeAccount(account, { disabled: !account.disabled })}>
            ${account.disabled ? "Let in again" : "Shut out"}</button></td></tr>`)}
    </tbody></table></div>
    <form onSubmit=${invite}><label>Invite somebody as<select name="role">
      ${ROLES.map((role) => html`<option selected=${role === "responder"}>${role}</option>`)}</select></label>
      <button type="submit">Make a link</button></form></section>`;
}

function Tokens() {
  return html`<section aria-labelledby="tokens"><h2 id="tokens">Robots' tokens</h2>
    <p class="about">A robot shows its token with everything that it sends. Revoke one that may be in the wrong hands.</p>
    ${state.tokens.length === 0 ? html`<p class="none">No robot has a token yet.</p>` : html`
    <div class="table"><table><thead><tr><th>For</th><th>Mission</th><th>Robot</th><th>Made</th><th></th></tr></thead><tbody>
      ${state.tokens.map((token) => html`<tr key=${token.token_id} class=${token.revoked_unix_s ? "off" : ""}>
        <td>${token.label}</td><td>${token.mission_id ?? "all"}</td><td>${token.robot_id ?? "all"}</td>
        <td>${when(token.created_unix_s)} by ${token.by}</td>
        <td>${token.revoked_unix_s ? `revoked ${when(token.revoked_unix_s)}` : html`<button type="button" class="danger"
          onClick=${() => act(() => request("DELETE", `/robot-tokens/${token.token_id}`))}>Revoke</button>`}</td></tr>`)}
    </tbody></table></div>`}
    <form onSubmit=${makeToken}>
      <label>What it is for<input name="label" required maxlength="60" placeholder="red rover"/></label>
      <label>Mission<select name="mission"><option value="">all missions</option>
        ${state.missions.map(({ mission_id, name }) => html`<option value=${mission_id}>${name}</option>`)}</select></label>
      <label>Robot<input name="robot" maxlength="64" placeholder="all robots" pattern="[A-Za-z0-9][A-Za-z0-9._:~\\-]*"/></label>
      <button type="submit">Make a token</button></form></section>`;
}

function Changes() {
  return html`<section aria-labelledby="changes"><h2 id="changes">Changes</h2>
    <p class="about">Who changed what, the latest first. Nothing can be taken out of this list.</p>
    <div class="table"><table><thead><tr><th>When</th><th>Who</th><th>What</th><th>Mission</th></tr></thead><tbody>
      ${state.entries.map((entry) => html`<tr key=${entry.audit_id}><td>${when(entry.unix_s)}</td>
        <td>${entry.by}, ${entry.role}</td>
        <td class="words">${entry.action.replaceAll("_", " ")}${entry.subject && `: ${entry.subject}`}</td>
        <td>${entry.mission_id ?? ""}</td></tr>`)}
    </tbody></table></div>
    ${state.more && html`<button type="button" onClick=${loadOlder}>Show older changes</button>`}</section>`;
}

function show() {
  page.removeAttribute("aria-busy");
  render(html`${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}
    <${Secret} /><${People} /><${Tokens} /><${Changes} />`, page);
}

load().then(() => {
  page.textContent = "";
  show();
}, (error) => {
  page.removeAttribute("aria-busy");
  page.textContent = error instanceof ApiError ? error.message : String(error);
});
