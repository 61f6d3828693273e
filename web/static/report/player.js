/* The film of a report: the map and the robots at any moment, from what is in the file itself. */
"use strict";
(() => {
  const data = document.getElementById("film");
  const root = document.getElementById("player");
  if (!data || !root) return;
  /**
   * @type {{times: number[], maps: (number | null)[], tags: [number, number][],
   *   robots: {name: string, color: string, poses: ([number, number, number] | null)[]}[],
   *   pictures: Record<string, {origin_m: [number, number], width: number, height: number, resolution_m: number, png: string}>,
   *   victims: {name: string, at: [number, number], since: number}[]}}
   */
  const film = JSON.parse(data.textContent ?? "{}");
  const { times, robots, victims, tags, maps, pictures } = film;
  /** @type {Record<string, HTMLImageElement>} */
  const images = {};
  for (const [version, { png }] of Object.entries(pictures)) {
    images[version] = new Image();
    images[version].addEventListener("load", () => draw());
    images[version].src = png;
  }
  const places = robots.flatMap(({ poses }) => poses.flatMap((pose) => (pose ? [[pose[0], pose[1]]] : [])))
    .concat(Object.values(pictures).flatMap(({ origin_m: [x, y], width, height, resolution_m }) =>
      [[x, y], [x + width * resolution_m, y + height * resolution_m]]));
  const low = [0, 1].map((k) => Math.min(...places.map((place) => place[k])) - 0.5);
  const high = [0, 1].map((k) => Math.max(...places.map((place) => place[k])) + 0.5);

  const canvas = document.createElement("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "The plan at the moment chosen below");
  const play = document.createElement("button");
  const slider = document.createElement("input");
  const speed = document.createElement("select");
  const words = document.createElement("output");
  play.type = "button";
  slider.type = "range";
  slider.max = String(times.length - 1);
  slider.setAttribute("aria-label", "Moment of the mission");
  speed.setAttribute("aria-label", "Speed");
  for (const factor of [1, 10, 30, 60]) speed.append(new Option(`${factor}×`, String(factor), factor === 30, factor === 30));
  const row = document.createElement("div");
  row.className = "row";
  row.append(play, speed, slider, words);
  root.append(canvas, row);

  let at = times.length - 1;
  let timer = 0;

  function draw() {
    const ratio = devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = canvas;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const scale = Math.min(width / (high[0] - low[0]), height / (high[1] - low[1]));
    const left = (width - scale * (high[0] - low[0])) / 2;
    const top = (height - scale * (high[1] - low[1])) / 2;
    /** @param {number} x @param {number} y @returns {[number, number]} */
    const to = (x, y) => [left + scale * (x - low[0]), top + scale * (high[1] - y)];
    ctx.scale(ratio, ratio);
    ctx.imageSmoothingEnabled = false;
    const map = maps[at] === null ? undefined : pictures[String(maps[at])];
    if (map && images[String(maps[at])].complete) {
      const [x, y] = to(map.origin_m[0], map.origin_m[1] + map.height * map.resolution_m);
      ctx.drawImage(images[String(maps[at])], x, y, scale * map.width * map.resolution_m, scale * map.height * map.resolution_m);
    }
    ctx.fillStyle = "#6a4d00";
    for (const [x, y] of tags) ctx.fillRect(to(x, y)[0] - 2, to(x, y)[1] - 2, 4, 4);
    for (const { color, poses } of robots) drawWay(ctx, poses.slice(0, at + 1), color, to);
    ctx.font = "600 13px system-ui, sans-serif";
    for (const { name, at: [x, y], since } of victims) {
      if (since > times[at] + 1) continue;
      ctx.fillStyle = "#b00f1c";
      ctx.fillRect(to(x, y)[0] - 6, to(x, y)[1] - 6, 12, 12);
      ctx.fillText(name, to(x, y)[0] + 9, to(x, y)[1] + 4);
    }
    for (const { name, color, poses } of robots) {
      const pose = poses[at];
      if (pose) drawRobot(ctx, to(pose[0], pose[1]), pose[2], name, color);
    }
    slider.value = String(at);
    words.textContent = new Date(1000 * times[at]).toLocaleTimeString("en-GB");
    play.textContent = timer ? "Pause" : "Play";
  }

  /** @param {CanvasRenderingContext2D} ctx @param {([number, number, number] | null)[]} poses @param {string} color @param {(x: number, y: number) => [number, number]} to */
  function drawWay(ctx, poses, color, to) {
    ctx.strokeStyle = color;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    let isOn = false;
    for (const pose of poses) {
      if (pose) isOn ? ctx.lineTo(...to(pose[0], pose[1])) : ctx.moveTo(...to(pose[0], pose[1]));
      isOn = pose !== null;
    }
    ctx.stroke();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {[number, number]} place @param {number} yaw @param {string} name @param {string} color */
  function drawRobot(ctx, [x, y], yaw, name, color) {
    ctx.save();
    ctx.translate(x, y);
    ctx.rotate(-yaw);
    ctx.fillStyle = color;
    ctx.strokeStyle = "#fff";
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.moveTo(12, 0);
    ctx.lineTo(-8, 8);
    ctx.lineTo(-5, 0);
    ctx.lineTo(-8, -8);
    ctx.closePath();
    ctx.stroke();
    ctx.fill();
    ctx.restore();
    ctx.fillStyle = color;
    ctx.fillText(name, x + 11, y + 14);
  }

  /** The last frame at or before a moment. @param {number} unix_s */
  const frameAt = (unix_s) => Math.max(0, times.findLastIndex((time) => time <= unix_s + 0.5));

  function pause() {
    clearInterval(timer);
    timer = 0;
    draw();
  }

  play.addEventListener("click", () => {
    if (timer) return pause();
    if (at === times.length - 1) at = 0;
    let moment = times[at];
    timer = setInterval(() => {
      moment += 0.1 * Number(speed.value);
      // Where nothing happened for long, the film goes on at once.
      if (at + 1 < times.length && times[at + 1] - moment > 20) moment = times[at + 1];
      at = Math.max(at, frameAt(moment));
      if (at === times.length - 1) pause();
      else draw();
    }, 100);
    draw();
  });
  slider.addEventListener("input", () => {
    at = Number(slider.value);
    draw();
  });
  document.addEventListener("click", (event) => {
    const { unixS } = /** @type {HTMLElement} */ (event.target).dataset ?? {};
    if (!unixS) return;
    at = frameAt(Number(unixS));
    pause();
    root.scrollIntoView({ block: "center" });
  });
  addEventListener("resize", draw);
  draw();
})();
