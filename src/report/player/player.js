"use strict";
// Starts the players of a page. Encoded lists are little-endian, as is every machine that runs a browser.
for (const figure of document.querySelectorAll(".player")) startPlayer(figure);

function startPlayer(figure) {
  const playback = JSON.parse(figure.querySelector(".playback").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const data = Object.fromEntries(Object.entries(playback.numbers).map(([name, text]) => [name, floats(text)]));
  const ranges = bytes(playback.ranges), scores = bytes(playback.scores);
  const moving = discReader(playback.moving), predicted = discReader(playback.predicted);
  const map = figure.querySelector(".map-canvas"), timeline = figure.querySelector(".timeline");
  const slider = figure.querySelector("input[type=range]");
  const playButton = figure.querySelector("[data-action=play]");
  const speed = figure.querySelector("[data-action=speed]");
  const eventButtons = [...figure.querySelectorAll(".events [data-frame]")];
  const mapImage = loadMapImage(figure.closest("section"));
  const lastFrame = playback.frames - 1;
  let frame = 0, isPlaying = false, lastUpdate = 0, pendingTime = 0, colours = {}, curveImage = null;

  // Returns a function from a frame to its discs, five numbers each.
  function discReader({ counts, numbers }) {
    const countOf = new Uint16Array(bytes(counts).buffer), all = floats(numbers);
    const starts = [0];
    for (const count of countOf) starts.push(starts[starts.length - 1] + count);
    return (index) => {
      const discs = [];
      for (let disc = starts[index]; disc < starts[index + 1]; disc++) discs.push(all.subarray(5 * disc, 5 * disc + 5));
      return discs;
    };
  }

  // Takes the image of the occupancy grid from the map picture of the same section.
  function loadMapImage(section) {
    const element = section && section.querySelector(".map-picture image.ground");
    if (!element) return null;
    const picture = new Image();
    picture.onload = () => draw();
    picture.src = element.getAttribute("href");
    const transform = element.getAttribute("transform").match(/-?[\d.]+/g).map(Number);
    return { picture, transform, hasCells: element.classList.contains("cells") };
  }

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["panel", "outside", "ink", "muted", "rule", "grid", "robot", "command", "path", "moving", "bad", "gap", "latency",
      "rock-strength", "speed-0", "speed-1", "speed-2", "speed-3"]) colours[name] = style.getPropertyValue("--" + name).trim();
    colours.ramp = [0, 1, 2, 3].map((step) => rgb(colours["speed-" + step]));
    curveImage = null;
  }

  const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

  // The colour of the ramp at a share from 0 to 1.
  function rampColour(share) {
    const position = share * 3, step = Math.min(2, Math.floor(position)), part = position - step;
    const [from, to] = [colours.ramp[step], colours.ramp[step + 1]];
    return "rgb(" + from.map((value, index) => Math.round(value + part * (to[index] - value))).join(" ") + ")";
  }

  const isShown = (layer) => figure.querySelector("[data-layer=" + layer + "]").checked;

  // Gives a canvas the resolution of the screen. Returns its context and its size in CSS pixels.
  function prepare(canvas, height) {
    const width = canvas.clientWidth, ratio = window.devicePixelRatio || 1;
    canvas.style.height = height + "px";
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return { context, width, height };
  }

  function draw() {
    if (!colours.panel) readColours();
    drawMap();
    drawTimeline();
    updateReadings();
  }

  function drawMap() {
    const fullHeight = Math.min(map.clientWidth * playback.height / playback.width, window.innerHeight * 0.7);
    const { context, width, height } = prepare(map, Math.max(240, fullHeight));
    const robot = [data.x[frame], data.y[frame]];
    // Shows the whole drawing, or 10 m around the robot.
    const follows = isShown("follow");
    const wholeZoom = Math.min(width / playback.width, height / playback.height);
    const zoom = follows ? Math.max(wholeZoom, Math.min(width, height) / (10 * playback.scale)) : wholeZoom;
    const center = follows ? robot : [playback.width / 2, playback.height / 2];
    context.fillStyle = colours.outside;
    context.fillRect(0, 0, width, height);
    context.translate(width / 2, height / 2);
    context.scale(zoom, zoom);
    context.translate(-center[0], -center[1]);
    const pixel = 1 / zoom;
    drawGrid(context);
    drawPaths(context, pixel);
    if (isShown("lidar")) drawLidar(context, pixel);
    if (isShown("predictions")) drawPredicted(context);
    for (const [x, y, radius] of moving(frame)) drawDisc(context, x, y, radius, colours.moving, 0.55);
    if (isShown("trajectories")) drawTrajectories(context, pixel);
    drawTrack(context, pixel);
    drawRobot(context, pixel);
  }

  function drawGrid(context) {
    if (!mapImage || !mapImage.picture.complete || !mapImage.picture.naturalWidth) return;
    const { picture, transform, hasCells } = mapImage;
    context.save();
    context.transform(...transform);
    context.imageSmoothingEnabled = !hasCells;
    // Free cells are transparent in the image.
    context.fillStyle = colours.panel;
    context.fillRect(0, 0, picture.naturalWidth, picture.naturalHeight);
    context.globalAlpha = Number(colours["rock-strength"]) || 1;
    context.drawImage(picture, 0, 0);
    context.restore();
  }

  function drawLine(context, points) {
    context.beginPath();
    for (const [x, y] of points) context.lineTo(x, y);
    context.stroke();
  }

  function drawDisc(context, x, y, radius, colour, opacity) {
    context.globalAlpha = opacity;
    context.fillStyle = colour;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
  }

  function drawPaths(context, pixel) {
    context.strokeStyle = colours.path;
    context.lineWidth = 5 * pixel;
    context.globalAlpha = 0.5;
    const current = playback.paths[data.plan[frame]];
    if (current) drawLine(context, current);
    context.globalAlpha = 1;
    const [x, y] = playback.goal;
    context.strokeStyle = colours.ink;
    context.lineWidth = 2 * pixel;
    for (const radius of [8, 3]) {
      context.beginPath();
      context.arc(x, y, radius * pixel, 0, 2 * Math.PI);
      context.stroke();
    }
    drawDisc(context, data.target_x[frame], data.target_y[frame], 5 * pixel, colours.path, 1);
  }

  // The track up to the current frame.
  function drawTrack(context, pixel) {
    context.strokeStyle = colours.robot;
    context.lineWidth = 2 * pixel;
    context.globalAlpha = 0.7;
    context.beginPath();
    for (let index = 0; index <= frame; index++) context.lineTo(data.x[index], data.y[index]);
    context.stroke();
    context.globalAlpha = 1;
  }

  function drawLidar(context, pixel) {
    const { beams, angle_min, angle_increment, range_max } = playback.lidar;
    const [x, y, yaw] = [data.x[frame], data.y[frame], data.yaw[frame]];
    context.fillStyle = colours.bad;
    const dot = 3 * pixel;
    for (let beam = 0; beam < beams; beam++) {
      const range = ranges[frame * beams + beam];
      if (range >= 254) continue;
      const distance = range / 253 * range_max * playback.scale, angle = yaw + angle_min + beam * angle_increment;
      context.fillRect(x + distance * Math.cos(angle) - dot / 2, y - distance * Math.sin(angle) - dot / 2, dot, dot);
    }
  }

  // The predicted positions of moving obstacles over the horizon, fainter with time.
  function drawPredicted(context) {
    for (const [x, y, radius, vx, vy] of predicted(frame)) {
      for (let part = 0; part <= 4; part++) {
        const time = part / 4 * playback.window.horizon_s;
        drawDisc(context, x + vx * time, y + vy * time, radius, colours.moving, 0.22 - 0.035 * part);
      }
    }
  }

  // The points of a trajectory at constant speed and turn rate.
  function trajectory(v, omega) {
    const points = [], parts = 12;
    const [x, y, yaw] = [data.start_x[frame], data.start_y[frame], data.start_yaw[frame]];
    for (let part = 0; part <= parts; part++) {
      const time = part / parts * playback.window.horizon_s, half = omega * time / 2;
      const chord = v * time * (Math.abs(half) < 1e-4 ? 1 : Math.sin(half) / half) * playback.scale;
      points.push([x + chord * Math.cos(yaw + half), y - chord * Math.sin(yaw + half)]);
    }
    return points;
  }

  function drawTrajectories(context, pixel) {
    if (Number.isNaN(data.start_x[frame])) return;
    const { trajectories, columns } = playback.window, rows = trajectories / columns;
    const between = (low, high, index, count) => count > 1 ? low + (high - low) * index / (count - 1) : low;
    context.lineWidth = 1.2 * pixel;
    // The best ones are drawn last, above the others.
    const order = Array.from({ length: trajectories }, (_, index) => index);
    order.sort((one, other) => scores[frame * trajectories + one] - scores[frame * trajectories + other]);
    for (const index of order) {
      const score = scores[frame * trajectories + index];
      if (score === 7) continue;
      const v = between(data.v_min[frame], data.v_max[frame], index % columns, columns);
      const omega = between(data.omega_min[frame], data.omega_max[frame], Math.floor(index / columns), rows);
      context.strokeStyle = score < 8 ? colours.bad : rampColour((score - 8) / 247);
      context.globalAlpha = score < 8 ? 0.18 : 0.9;
      drawLine(context, trajectory(v, omega));
    }
    context.globalAlpha = 1;
    if (Number.isNaN(data.v[frame])) return;
    context.strokeStyle = colours.command;
    context.lineWidth = 3.5 * pixel;
    drawLine(context, trajectory(data.v[frame], data.omega[frame]));
  }

  function drawRobot(context, pixel) {
    const [x, y, yaw] = [data.x[frame], data.y[frame], data.yaw[frame]];
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)], scale = playback.scale;
    let front = 0;
    for (const [ahead, left, radius] of playback.footprint) {
      const [discX, discY] = [x + (ahead * cos - left * sin) * scale, y - (ahead * sin + left * cos) * scale];
      drawDisc(context, discX, discY, radius * scale, colours.robot, 0.6);
      front = Math.max(front, (ahead + radius) * scale);
    }
    context.strokeStyle = colours.ink;
    context.lineWidth = 2 * pixel;
    drawLine(context, [[x, y], [x + front * cos, y - front * sin]]);
  }

  // The curves are drawn once for each size and theme; the line at the current frame is drawn over them.
  function drawTimeline() {
    const { context, width, height } = prepare(timeline, 144 + PROTECTION_LANE);
    const size = width + " " + window.devicePixelRatio;
    if (!curveImage || curveImage.size !== size) {
      curveImage = { size, image: drawCurves(timeline.width, timeline.height, width, height) };
    }
    context.drawImage(curveImage.image, 0, 0, width, height);
    const x = frameToX(width)(frame);
    context.strokeStyle = colours.ink;
    context.lineWidth = 1.5;
    drawLine(context, [[x, 0], [x, height]]);
  }

  // Height of the lane with the faults, below the curves.
  const FAULT_LANE = 12;

  // Height of the lane of the protective layer above it: its title and its bars.
  const PROTECTION_LANE = 28;

  const frameToX = (width) => (index) => 4 + (width - 8) * (lastFrame > 0 ? index / lastFrame : 0);

  function drawCurves(pixelWidth, pixelHeight, width, height) {
    const image = document.createElement("canvas");
    [image.width, image.height] = [pixelWidth, pixelHeight];
    const context = image.getContext("2d"), toX = frameToX(width), rowHeight = (height - FAULT_LANE - PROTECTION_LANE) / 3;
    context.scale(pixelWidth / width, pixelHeight / height);
    drawFaults(context, toX, height);
    drawProtection(context, toX, height - FAULT_LANE);
    const rows = [
      ["speed, m/s", [[data.commanded_speed, colours.command], [data.speed, colours.robot]], null],
      ["gap, m", [[data.gap, colours.gap]], 3],
      ["decision time, ms", [[data.decision_time, colours.latency]], null],
    ];
    rows.forEach(([name, curves, limit], row) => {
      const values = curves.flatMap(([curve]) => Array.from(curve).filter(Number.isFinite));
      const high = limit ?? values.reduce((high, value) => Math.max(high, value), 0.01);
      const low = values.reduce((low, value) => Math.min(low, value), 0);
      const toY = (value) => (row + 1) * rowHeight - 3 - (rowHeight - 20) * (Math.min(value, high) - low) / (high - low);
      context.strokeStyle = colours.grid;
      context.lineWidth = 1;
      drawLine(context, [[0, toY(0)], [width, toY(0)]]);
      for (const [curve, colour] of curves) {
        context.strokeStyle = colour;
        context.lineWidth = 1.3;
        context.beginPath();
        curve.forEach((value, index) => { if (Number.isFinite(value)) context.lineTo(toX(index), toY(value)); });
        context.stroke();
      }
      context.fillStyle = colours.muted;
      context.font = "11px system-ui, sans-serif";
      context.fillText(name + ", up to " + high.toFixed(2), 6, row * rowHeight + 12);
    });
    return image;
  }

  // Shades the ticks of each fault behind the curves, and draws a bar with a triangle at its first tick in the lane.
  function drawFaults(context, toX, height) {
    context.fillStyle = colours.bad;
    for (const [from, to] of playback.faults.spans) {
      const left = toX(from), width = Math.max(1.5, toX(to) - left);
      context.globalAlpha = 0.25;
      context.fillRect(left - 0.5, 0, width, height - FAULT_LANE);
      context.globalAlpha = 1;
      context.fillRect(left - 0.5, height - 4, width, 4);
      context.beginPath();
      for (const [x, y] of [[-5, 0], [5, 0], [0, 4 - FAULT_LANE]]) context.lineTo(left + x, height + y);
      context.fill();
    }
  }

  // Draws a bar for each action of the protective layer above a height: a high one for a stop, a low one for a reduced command.
  function drawProtection(context, toX, bottom) {
    const { title, stops, reductions } = playback.protection;
    context.fillStyle = colours.latency;
    for (const [events, height] of [[reductions, 5], [stops, 11]]) {
      for (const [from, to] of events.spans) {
        const left = toX(from), width = Math.max(1.5, toX(to) - left);
        context.fillRect(left - 0.5, bottom - 2 - height, width, height);
      }
    }
    context.fillStyle = colours.muted;
    context.font = "11px system-ui, sans-serif";
    context.fillText(title, 6, bottom - PROTECTION_LANE + 12);
  }

  // The texts of the events at a frame.
  function textsAt(events, index) {
    const spans = events.spans.filter(([from, to]) => from <= index && index <= to);
    return spans.map(([, , text]) => events.texts[text]);
  }

  function modeAt(index) {
    let current = "";
    for (const [from, mode] of playback.modes) if (from <= index) current = mode;
    return current;
  }

  function updateReadings() {
    // Zero has no minus sign.
    const number = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
    const fixed = (name, digits) => Number.isFinite(data[name][frame]) ? number(data[name][frame], digits) : "–";
    const faults = textsAt(playback.faults, frame);
    const { stops, reductions } = playback.protection;
    const actions = [...textsAt(stops, frame), ...textsAt(reductions, frame)];
    const isLate = data.decision_time[frame] > playback.deadline_ms;
    const readings = {
      time: fixed("time", 2), mode: modeAt(frame), fault: faults.join("; ") || "none",
      protection: actions.join("; ") || "no action", speed: fixed("speed", 2),
      turn_rate: fixed("turn_rate", 2), gap: fixed("gap", 3),
      command: fixed("commanded_speed", 2) + " m/s, " + fixed("commanded_turn_rate", 2) + " rad/s",
      decision_time: fixed("decision_time", 2) + (isLate ? " LATE" : ""),
      admissible: data.samples[frame] > 0 ? data.admissible[frame] + " of " + data.samples[frame] : "–",
      heading: fixed("heading", 3), clearance: fixed("clearance", 3), velocity: fixed("velocity", 3),
      path: fixed("path", 3), score: fixed("score", 7),
      plan: data.plan[frame] + 1 + " of " + playback.paths.length,
    };
    for (const [name, text] of Object.entries(readings)) figure.querySelector("[data-reading=" + name + "]").textContent = text;
    figure.querySelector("[data-reading=fault]").classList.toggle("is-fault", faults.length > 0);
    for (const button of eventButtons) button.setAttribute("aria-current", Number(button.dataset.frame) === frame);
    slider.value = frame;
    slider.setAttribute("aria-valuetext", [readings.time + " s", readings.mode, ...faults, ...actions].join(", "));
  }

  function show(index) {
    frame = Math.max(0, Math.min(lastFrame, index));
    draw();
  }

  function setPlaying(on) {
    isPlaying = on;
    playButton.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (frame === lastFrame) show(0);
    [lastUpdate, pendingTime] = [performance.now(), 0];
    requestAnimationFrame(advance);
  }

  // Advances by the frames of the elapsed time, scaled by the selected speed.
  function advance(now) {
    if (!isPlaying) return;
    pendingTime += (now - lastUpdate) / 1000 * Number(speed.value);
    lastUpdate = now;
    let next = frame;
    while (next < lastFrame && pendingTime >= data.time[next + 1] - data.time[next]) {
      pendingTime -= data.time[next + 1] - data.time[next];
      next++;
    }
    if (next !== frame) show(next);
    if (next === lastFrame) return setPlaying(false);
    requestAnimationFrame(advance);
  }

  function stopAt(index) {
    setPlaying(false);
    show(index);
  }

  playButton.addEventListener("click", () => setPlaying(!isPlaying));
  figure.querySelector("[data-action=back]").addEventListener("click", () => stopAt(frame - 1));
  figure.querySelector("[data-action=forward]").addEventListener("click", () => stopAt(frame + 1));
  slider.addEventListener("input", () => stopAt(Number(slider.value)));
  for (const button of eventButtons) button.addEventListener("click", () => stopAt(Number(button.dataset.frame)));
  for (const layer of figure.querySelectorAll("[data-layer]")) layer.addEventListener("change", draw);
  const keyActions = {
    " ": () => setPlaying(!isPlaying), ArrowLeft: () => stopAt(frame - 1), ArrowRight: () => stopAt(frame + 1),
    Home: () => stopAt(0), End: () => stopAt(lastFrame),
  };
  map.addEventListener("keydown", (event) => {
    const action = keyActions[event.key];
    if (action) { event.preventDefault(); action(); }
  });
  timeline.addEventListener("pointerdown", (event) => {
    const share = (event.offsetX - 4) / (timeline.clientWidth - 8);
    stopAt(Math.round(share * lastFrame));
  });
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); draw(); });
  // A page opened at #t=120 starts at that time.
  const time = /^#t=([\d.]+)$/.exec(location.hash);
  show(time ? data.time.findLastIndex((value) => value <= Number(time[1])) : 0);
}
