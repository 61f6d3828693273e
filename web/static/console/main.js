/** The console: which mission, its stream, and the parts of the page that show it. */

import { learnWho } from "./account.js";
import { ApiError, refusal, request } from "./api.js";
import { AlertList, TagCard } from "./alerts.js";
import { attachDivider } from "./divider.js";
import { EventFeed } from "./events.js";
import { HelpSheet, openHelp, pressed } from "./keys.js";
import { closeMenus } from "./look_menu.js";
import { toggleMeasure } from "./measure.js";
import { isOpen } from "./node_sensors.js";
import { PhotoViewer } from "./photos.js";
import { PastScene } from "./past_scene.js";
import { Plan } from "./plan.js";
import { RobotList } from "./robot_list.js";
import { orderByKey } from "./robot_orders.js";
import { Scene } from "./scene.js";
import { PlanTools } from "./stage.js";
import { Sounds } from "./sound.js";
import { StopControl } from "./stop_control.js";
import { Store } from "./store.js";
import { Stream } from "./stream.js";
import { PastBanner, TimeBar, timeKeys } from "./time_bar.js";
import { TimeMarks } from "./time_marks.js";
import { Banners, TopBar, Veil } from "./top_bar.js";
import { html, render } from "./vendor.js";
import { standing } from "./victim_list.js";
import { inboxKey, VictimInbox } from "./victims.js";

const MISSIONS_MS = 5000;
const SHORTEST_RENDER_MS = 80;
const TICK_MS = 500; // ages and clocks on the page

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const store = new Store();
const stops = new StopControl(store);
const sounds = new Sounds(store);
const marks = new TimeMarks(store);
const plan = new Plan(element("plan"), store);
new Scene(element("scene-pane"), store);
new PastScene(element("scene-pane"), store);
attachDivider(element("divider"), element("stage"), store);
/** @type {Stream | null} */
let stream = null;

/** @param {"robot" | "victim" | "tag" | "note"} kind */
const select = (kind) => (/** @type {string} */ id) => {
  store.select({ kind, id });
  plan.centreOnSelected();
};

/** @param {import("./store.js").Selected} subject */
const show = ({ kind, id }) => select(kind)(id);

/** @param {string} missionId */
function openMission(missionId) {
  if (missionId === store.missionId) return;
  stream?.close();
  store.best.clear();
  store.past.clear(missionId);
  marks.open(missionId);
  store.clearBoard();
  store.missionId = missionId;
  store.selected = null;
  store.group.clear();
  store.connection = { state: "loading", heardAt: Date.now(), attempt: 0, retryAt: 0, reason: "" };
  const address = new URL(location.href);
  address.searchParams.set("mission", missionId);
  history.replaceState(null, "", address);
  stream = new Stream(store, missionId, (text) => (element("alarm-announcer").textContent = `Alarm: ${text}`));
  plan.fit();
  store.changed();
}

/** Ask for the missions again and again: new ones appear, and the first one opens by itself. */
async function watchMissions() {
  try {
    const { missions } = await request("GET", "/missions");
    store.missions = missions;
    const wanted = store.missionId ?? new URLSearchParams(location.search).get("mission");
    if (!store.missionId) {
      const running = missions.filter((/** @type {any} */ mission) => mission.state === "running");
      const newest = [...(running.length ? running : missions)].sort((a, b) => b.created_unix_s - a.created_unix_s)[0];
      if (wanted) openMission(wanted);
      else if (newest) openMission(newest.mission_id);
      else store.connection.state = "none";
    }
  } catch (error) {
    if (!store.missionId) {
      store.connection.state = "loading";
      store.connection.reason = error instanceof ApiError ? `${error.message} Trying again.` : String(error);
    }
  }
  store.changed();
  setTimeout(watchMissions, store.missionId ? MISSIONS_MS : 1500);
}

/** @param {"plan" | "both" | "scene"} view */
function setView(view) {
  store.view = view;
  store.keepPreferences();
}

const TABS = [["robots", "Robots"], ["victims", "Victims"], ["events", "Alerts"]];

function Tabs() {
  return TABS.map(([tab, label]) => html`<button type="button" aria-pressed=${store.tab === tab} onClick=${() => {
    store.tab = tab;
    store.changed();
  }}>${label}${countOf(tab) > 0 && html` <span class="count">${countOf(tab)}</span>`}</button>`);
}

/** What waits on a tab: victims, or alerts that nobody has taken note of. @param {string} tab */
function countOf(tab) {
  return { victims: standing(store).length, events: [...store.alerts.values()].filter(isOpen).length }[tab] ?? 0;
}

function Notices() {
  return [...store.notices].map(([number, { text, level }]) => html`
    <div key=${number} class=${`notice notice-${level}`} role="alert"><span>${text}</span>
      <button type="button" aria-label="Dismiss this message" onClick=${() => {
        store.notices.delete(number);
        store.changed();
      }}>×</button></div>`);
}

let announced = "";

function renderPanels() {
  document.getElementById("boot")?.remove();
  sounds.update();
  const { state } = store.connection;
  document.body.dataset.tab = store.tab;
  document.body.dataset.view = store.view;
  document.body.dataset.time = store.past.at_s === null ? "live" : "past";
  document.body.dataset.map = store.best.isShown ? "best" : "live";
  document.body.dataset.connection = state;
  document.body.toggleAttribute("data-asking", plan.isAsking());
  document.title = `${state === "stale" ? "STALE · " : ""}${store.mission?.name ?? "Waymark"} · Waymark`;
  render(html`<${TopBar} store=${store} stops=${stops} onMission=${openMission} onView=${setView} />`, element("top"));
  render(html`<${PastBanner} store=${store} /><${Banners} store=${store} stops=${stops} />`, element("banner"));
  render(html`<${RobotList} store=${store} stops=${stops} onSelect=${select("robot")} />`, element("robots"));
  render(html`
    <section id="alerts" aria-label="Alerts"><${AlertList} store=${store} onSelect=${show} /></section>
    <section id="victims" aria-label="Victims"><${VictimInbox} store=${store} onSelect=${select("victim")} /></section>
    <section id="events" aria-label="Events"><${EventFeed} store=${store} onSelect=${select("robot")} /></section>`,
    element("reports"));
  render(html`<${PlanTools} store=${store} plan=${plan} onSelect=${show} /><${TagCard} store=${store} />`, element("plan-tools"));
  render(html`<${Veil} store=${store} onRetry=${() => stream?.retry()} />`, element("veil"));
  render(html`<${TimeBar} store=${store} marks=${marks} />`, element("time"));
  render(html`<${Tabs} />`, element("tabs"));
  render(html`<${Notices} />`, element("notices"));
  render(store.photo && store.photos.has(store.photo) ? html`<${PhotoViewer} store=${store} />` : null, element("viewer"));
  render(html`<${HelpSheet} shortCuts=${SHORT_CUTS} />`, element("sheets"));
  if (state !== announced) {
    announced = state;
    element("announcer").textContent = { live: "Connected, live", stale: "Data is stale", reconnecting: "Reconnecting" }[
      /** @type {string} */ (state)] ?? "";
  }
}

let renderedAt = 0;
let waiting = 0;
store.subscribe(() => {
  if (waiting) return;
  waiting = setTimeout(() => {
    waiting = 0;
    renderedAt = performance.now();
    renderPanels();
  }, Math.max(0, renderedAt + SHORTEST_RENDER_MS - performance.now()));
});

/** @param {string} key */
const judge = (key) => inboxKey(store, key, select("victim"));

/** What is asked for first, then what is selected. */
function leave() {
  if (store.picking || store.draft || store.measured) store.picking = store.draft = store.measured = null;
  else store.selected = null;
  store.changed();
}

/** @type {import("./keys.js").ShortCut[]} */
const SHORT_CUTS = [
  { keys: "?", words: "This sheet", act: openHelp },
  { keys: "/", words: "Find a robot, tag, victim or note", act: () => element("search").focus() },
  { keys: "f", words: "Show the whole mission", act: () => plan.fit() },
  { keys: "g", words: "Go along with the selected robot", act: () => plan.follow() },
  { keys: "m", words: "Measure", act: () => toggleMeasure(store) },
  { keys: "b", words: "Live or best map", act: () => (store.best.isShown ? store.best.showLive() : store.best.show()) },
  { keys: "1 2 3 4 5 6 7 8 9", words: "Select a robot, in the order of the list", act: (key) => {
    const robot = store.robotList()[Number(key) - 1];
    if (robot) select("robot")(robot.robot_id);
  } },
  { keys: "t h o p d", words: "The selected robot: return, hold or resume, go to, explore here, drop a tag",
    act: (key) => orderByKey(store, key) },
  { keys: "j k", words: "The next victim, the one before", act: judge },
  { keys: "c r e x", words: "The selected victim: confirmed, reached, extricated, dismissed", act: judge },
  ...timeKeys(store, marks),
  { keys: "Escape", words: "Leave what is open or selected", act: leave },
];
addEventListener("keydown", (event) => pressed(event, SHORT_CUTS));

addEventListener("look", () => store.changed());
closeMenus();
addEventListener("error", () => store.notify("This page has a fault and may not show everything. Reload it; the mission goes on."));
setInterval(() => {
  store.past.refresh();
  store.changed();
}, TICK_MS);
refusal.of = () => (store.past.at_s === null ? "" : "You look at the past. Go back to live first.");
renderPanels();
learnWho(store);
watchMissions();
