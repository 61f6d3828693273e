/** STOP and RESUME: orders that are sent until the server confirms them, and that say so meanwhile. */

import { missionPath, request } from "./api.js";

import { age, fixed } from "./format.js";

/** @import {Store} from "./store.js" */
/** @import {Robot} from "./types.js" */
/** @typedef {"free" | "sending" | "unconfirmed" | "ordered" | "silent" | "heard" | "braking" | "stopped"} StopState */

const ALL = "*";
const RETRY_MS = 1000;
const MOVES_MPS = 0.03;

export class StopControl {
  /** @param {Store} store */
  constructor(store) {
    this.store = store;
    /** Orders under way: robot id or "*" -> what is wanted and how often it was sent. */
    this.pending = /** @type {Map<string, {order: "stop" | "resume", tries: number, error: string}>} */ (new Map());
    /** Robots, or "*", that are asked a second time before they resume. */
    this.asked = /** @type {Map<string, number>} */ (new Map());
  }

  /** @param {string} [robotId] all robots when left out */
  stop(robotId = ALL) {
    if (this.pending.get(robotId)?.order === "stop") return;
    this.asked.clear();
    this.#send(robotId, "stop");
  }

  /**
   * Resuming takes two presses: the first only asks.
   * @param {string} [robotId] all robots when left out
   */
  resume(robotId = ALL) {
    if (this.pending.has(robotId)) return;
    if (!this.asked.has(robotId)) {
      this.asked.set(robotId, setTimeout(() => {
        this.asked.delete(robotId);
        this.store.changed();
      }, 5000));
      this.store.changed();
      return;
    }
    clearTimeout(this.asked.get(robotId));
    this.asked.delete(robotId);
    this.#send(robotId, "resume");
  }

  /**
   * @param {string} key
   * @param {"stop" | "resume"} order
   */
  async #send(key, order) {
    const { store } = this;
    const { missionId } = store;
    if (!missionId) return;
    const mine = { order, tries: 0, error: "" };
    this.pending.set(key, mine);
    const alarm = `STOP for ${key === ALL ? "all robots" : key} is NOT confirmed.`;
    const isCurrent = () => this.pending.get(key) === mine && store.missionId === missionId;
    while (isCurrent()) {
      mine.tries += 1;
      store.changed();
      try {
        await request("POST", `${missionPath(missionId)}/${order}`, { robots: key === ALL ? null : [key] });
        break;
      } catch (error) {
        mine.error = /** @type {Error} */ (error).message;
        if (order === "resume") {
          store.notify(`${key === ALL ? "The robots were" : `${key} was`} not resumed. ${mine.error}`);
          break;
        }
        store.notify(`${alarm} ${mine.error} It is being sent again.`, "alarm");
        await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
      }
    }
    if (this.pending.get(key) === mine) this.pending.delete(key);
    store.withdraw(alarm);
  }

  /**
   * What is known of one robot's STOP.
   * @param {Robot} robot
   * @returns {StopState}
   */
  stateOf(robot) {
    if (robot.stopped) {
      if (!robot.stop_heard) return "ordered";
      if (this.store.linkOf(robot, this.store.serverNow()).link !== "live") return "silent";
      return robot.speed_mps === null ? "heard" : moves(robot) ? "braking" : "stopped";
    }
    const pending = this.pending.get(robot.robot_id) ?? this.pending.get(ALL);
    if (pending?.order !== "stop") return "free";
    return pending.tries > 1 ? "unconfirmed" : "sending";
  }

  /** The same in words; none where there is no STOP. @param {Robot} robot */
  wordsOf(robot) {
    const { link, age_s } = this.store.linkOf(robot, this.store.serverNow());
    /** @type {Record<StopState, string>} */
    const words = {
      free: "",
      sending: "STOP is on its way to the server.",
      unconfirmed: "The server does not answer: STOP is sent again and again.",
      ordered: link === "live" ? "Has not heard STOP yet." : `Has not heard STOP: last heard ${age(age_s)}, stops once it is heard again.`,
      silent: `${moves(robot) ? "Still moved" : "Stood still"} when last heard, ${age(age_s)}: it had heard STOP.`,
      heard: "Has heard STOP; nobody knows whether it still moves.",
      braking: `Still moves, at ${fixed(robot.speed_mps, 2)} m/s: it has heard STOP.`,
      stopped: "Stands still: it has heard STOP.",
    };
    const isDown = robot.stopped && robot.agent_down && link === "live";
    return `${words[this.stateOf(robot)]}${isDown ? " Its agent is down, which STOP does not need." : ""}`;
  }

  /** @returns {{order: "stop" | "resume", tries: number, error: string} | undefined} order for all, under way */
  get pendingAll() {
    return this.pending.get(ALL);
  }

  /** @param {string} [robotId] */
  isAsked(robotId = ALL) {
    return this.asked.has(robotId);
  }
}

/** @param {Robot} robot */
const moves = ({ speed_mps }) => Math.abs(speed_mps ?? 0) > MOVES_MPS;
