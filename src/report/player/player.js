"use strict";
// Plays the films of a page. A film's lists are little-endian, as all machines with a browser are.
for (const figure of document.querySelectorAll(".player")) play(figure);

function play(figure) {
  const film = JSON.parse(figure.querySelector(".film").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const of = Object.fromEntries(Object.entries(film.numbers).map(([name, text]) => [name, floats(text)]));
  const ranges = bytes(film.ranges), scores = bytes(film.scores);
  const moving = lists(film.moving), predicted = lists(film.predicted);
  const stage = figure.querySelector(".stage"), strip = figure.querySelector(".strip");
  const slider = figure.querySelector("input[type=range]");
  const button = figure.querySelector("[data-does=play]");
  const speed = figure.querySelector("[data-does=speed]");
  const ground = groundOf(figure.closest("section"));
  const last = film.frames - 1;
  const listed = [...figure.querySelectorAll(".faults [data-frame]")];
  let frame = 0, playing = false, before = 0, ahead = 0, colours = {}, stripPicture = null;

  // The discs of each frame: five numbers each, from where the frame's begin.
  function lists({ counts, numbers }) {
    const many = new Uint16Array(bytes(counts).buffer), all = floats(numbers);
    const starts = [0];
    for (const count of many) starts.push(starts[starts.length - 1] + count);
    return (index) => {
      const discs = [];
      for (let disc = starts[index]; disc < starts[index + 1]; disc++) discs.push(all.subarray(5 * disc, 5 * disc + 5));
      return discs;
    };
  }

  // The ground's picture is in the page already, in the map of the same section.
  function groundOf(section) {
    const shown = section && section.querySelector(".map-picture image.ground");
    if (!shown) return null;
    const picture = new Image();
    picture.onload = () => draw();
    picture.src = shown.getAttribute("href");
    const numbers = shown.getAttribute("transform").match(/-?[\d.]+/g).map(Number);
    return { picture, numbers, cells: shown.classList.contains("cells") };
  }

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["panel", "outside", "ink", "muted", "rule", "grid", "robot", "command", "path", "moving", "bad", "gap", "latency",
      "rock-strength", "speed-0", "speed-1", "speed-2", "speed-3"]) colours[name] = style.getPropertyValue("--" + name).trim();
    colours.ramp = [0, 1, 2, 3].map((step) => rgb(colours["speed-" + step]));
    stripPicture = null;
  }

  const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

  // A colour of the ramp for a share from 0 to 1.
  function ramp(share) {
    const place = share * 3, step = Math.min(2, Math.floor(place)), part = place - step;
    const [from, to] = [colours.ramp[step], colours.ramp[step + 1]];
    return "rgb(" + from.map((value, index) => Math.round(value + part * (to[index] - value))).join(" ") + ")";
  }

  const wants = (layer) => figure.querySelector("[data-layer=" + layer + "]").checked;

  // A canvas as fine as the screen, and its size in the page's pixels.
  function prepare(canvas, height) {
    const width = canvas.clientWidth, fine = window.devicePixelRatio || 1;
    canvas.style.height = height + "px";
    if (canvas.width !== Math.round(width * fine) || canvas.height !== Math.round(height * fine)) {
      canvas.width = Math.round(width * fine);
      canvas.height = Math.round(height * fine);
    }
    const on = canvas.getContext("2d");
    on.setTransform(fine, 0, 0, fine, 0, 0);
    on.clearRect(0, 0, width, height);
    return { on, width, height };
  }

  function draw() {
    if (!colours.panel) readColours();
    drawStage();
    drawStrip();
    read();
  }

  function drawStage() {
    const tall = Math.min(stage.clientWidth * film.height / film.width, window.innerHeight * 0.7);
    const { on, width, height } = prepare(stage, Math.max(240, tall));
    const robot = [of.x[frame], of.y[frame]];
    // The whole drawing, or 10 m around the robot.
    const follows = wants("follow");
    const whole = Math.min(width / film.width, height / film.height);
    const zoom = follows ? Math.max(whole, Math.min(width, height) / (10 * film.scale)) : whole;
    const middle = follows ? robot : [film.width / 2, film.height / 2];
    on.fillStyle = colours.outside;
    on.fillRect(0, 0, width, height);
    on.translate(width / 2, height / 2);
    on.scale(zoom, zoom);
    on.translate(-middle[0], -middle[1]);
    const pixel = 1 / zoom;
    drawGround(on);
    drawPaths(on, pixel);
    if (wants("lidar")) drawLidar(on, pixel);
    if (wants("predicted")) drawPredicted(on, pixel);
    for (const [x, y, radius] of moving(frame)) disc(on, x, y, radius, colours.moving, 0.55);
    if (wants("fan")) drawFan(on, pixel);
    drawTrack(on, pixel);
    drawRobot(on, pixel);
  }

  function drawGround(on) {
    if (!ground || !ground.picture.complete || !ground.picture.naturalWidth) return;
    const { picture, numbers, cells } = ground;
    on.save();
    on.transform(...numbers);
    on.imageSmoothingEnabled = !cells;
    // The free ground is transparent: the page's own colour lies under it.
    on.fillStyle = colours.panel;
    on.fillRect(0, 0, picture.naturalWidth, picture.naturalHeight);
    on.globalAlpha = Number(colours["rock-strength"]) || 1;
    on.drawImage(picture, 0, 0);
    on.restore();
  }

  function line(on, points) {
    on.beginPath();
    for (const [x, y] of points) on.lineTo(x, y);
    on.stroke();
  }

  function disc(on, x, y, radius, colour, strength) {
    on.globalAlpha = strength;
    on.fillStyle = colour;
    on.beginPath();
    on.arc(x, y, radius, 0, 2 * Math.PI);
    on.fill();
    on.globalAlpha = 1;
  }

  function drawPaths(on, pixel) {
    on.strokeStyle = colours.path;
    on.lineWidth = 5 * pixel;
    on.globalAlpha = 0.5;
    const current = film.paths[of.path[frame]];
    if (current) line(on, current);
    on.globalAlpha = 1;
    const [x, y] = film.goal;
    on.strokeStyle = colours.ink;
    on.lineWidth = 2 * pixel;
    for (const radius of [8, 3]) {
      on.beginPath();
      on.arc(x, y, radius * pixel, 0, 2 * Math.PI);
      on.stroke();
    }
    disc(on, of.target_x[frame], of.target_y[frame], 5 * pixel, colours.path, 1);
  }

  // Everything driven up to now.
  function drawTrack(on, pixel) {
    on.strokeStyle = colours.robot;
    on.lineWidth = 2 * pixel;
    on.globalAlpha = 0.7;
    on.beginPath();
    for (let index = 0; index <= frame; index++) on.lineTo(of.x[index], of.y[index]);
    on.stroke();
    on.globalAlpha = 1;
  }

  function drawLidar(on, pixel) {
    const { beams, angle_min, angle_increment, range_max } = film.lidar;
    const [x, y, yaw] = [of.x[frame], of.y[frame], of.yaw[frame]];
    on.fillStyle = colours.bad;
    const dot = 3 * pixel;
    for (let beam = 0; beam < beams; beam++) {
      const range = ranges[frame * beams + beam];
      if (range >= 254) continue;
      const way = range / 253 * range_max * film.scale, angle = yaw + angle_min + beam * angle_increment;
      on.fillRect(x + way * Math.cos(angle) - dot / 2, y - way * Math.sin(angle) - dot / 2, dot, dot);
    }
  }

  // Where moving things are predicted to be over the horizon: from now on ever fainter.
  function drawPredicted(on) {
    for (const [x, y, radius, vx, vy] of predicted(frame)) {
      for (let part = 0; part <= 4; part++) {
        const time = part / 4 * film.fan.horizon_s;
        disc(on, x + vx * time, y + vy * time, radius, colours.moving, 0.22 - 0.035 * part);
      }
    }
  }

  // The points of an arc driven at constant speed and turn rate.
  function arc(v, omega) {
    const points = [], parts = 12;
    const [x, y, yaw] = [of.from_x[frame], of.from_y[frame], of.from_yaw[frame]];
    for (let part = 0; part <= parts; part++) {
      const time = part / parts * film.fan.horizon_s, half = omega * time / 2;
      const chord = v * time * (Math.abs(half) < 1e-4 ? 1 : Math.sin(half) / half) * film.scale;
      points.push([x + chord * Math.cos(yaw + half), y - chord * Math.sin(yaw + half)]);
    }
    return points;
  }

  function drawFan(on, pixel) {
    if (Number.isNaN(of.from_x[frame])) return;
    const { arcs, columns } = film.fan, rows = arcs / columns;
    const between = (low, high, index, count) => count > 1 ? low + (high - low) * index / (count - 1) : low;
    on.lineWidth = 1.2 * pixel;
    // The best ones last, so that they lie above the others.
    const order = Array.from({ length: arcs }, (_, index) => index);
    order.sort((one, other) => scores[frame * arcs + one] - scores[frame * arcs + other]);
    for (const index of order) {
      const score = scores[frame * arcs + index];
      if (score === 7) continue;
      const v = between(of.v_low[frame], of.v_high[frame], index % columns, columns);
      const omega = between(of.w_low[frame], of.w_high[frame], Math.floor(index / columns), rows);
      on.strokeStyle = score < 8 ? colours.bad : ramp((score - 8) / 247);
      on.globalAlpha = score < 8 ? 0.18 : 0.9;
      line(on, arc(v, omega));
    }
    on.globalAlpha = 1;
    if (Number.isNaN(of.v[frame])) return;
    on.strokeStyle = colours.command;
    on.lineWidth = 3.5 * pixel;
    line(on, arc(of.v[frame], of.omega[frame]));
  }

  function drawRobot(on, pixel) {
    const [x, y, yaw] = [of.x[frame], of.y[frame], of.yaw[frame]];
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    let front = 0;
    for (const [ahead, left, radius] of film.footprint) {
      const scale = film.scale;
      disc(on, x + (ahead * cos - left * sin) * scale, y - (ahead * sin + left * cos) * scale, radius * scale, colours.robot, 0.6);
      front = Math.max(front, (ahead + radius) * scale);
    }
    on.strokeStyle = colours.ink;
    on.lineWidth = 2 * pixel;
    line(on, [[x, y], [x + front * cos, y - front * sin]]);
  }

  // Three curves over the run, drawn once for a size and a theme; the mark moves over them.
  function drawStrip() {
    const { on, width, height } = prepare(strip, 144);
    const size = width + " " + window.devicePixelRatio;
    if (!stripPicture || stripPicture.size !== size) stripPicture = { size, picture: curves(strip.width, strip.height, width, height) };
    on.drawImage(stripPicture.picture, 0, 0, width, height);
    const x = across(width)(frame);
    on.strokeStyle = colours.ink;
    on.lineWidth = 1.5;
    line(on, [[x, 0], [x, height]]);
  }

  // Height of the lane below the curves, where faults are marked.
  const LANE = 12;

  const across = (width) => (index) => 4 + (width - 8) * (last > 0 ? index / last : 0);

  function curves(fineWidth, fineHeight, width, height) {
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = [fineWidth, fineHeight];
    const on = picture.getContext("2d"), at = across(width), tall = (height - LANE) / 3;
    on.scale(fineWidth / width, fineHeight / height);
    drawFaults(on, at, height);
    const rows = [
      ["speed, m/s", [[of.told_speed, colours.command], [of.speed, colours.robot]], null],
      ["gap, m", [[of.gap, colours.gap]], 3],
      ["decision, ms", [[of.took, colours.latency]], null],
    ];
    rows.forEach(([name, lines, most], row) => {
      const shown = lines.flatMap(([values]) => Array.from(values).filter(Number.isFinite));
      const high = most ?? shown.reduce((high, value) => Math.max(high, value), 0.01);
      const low = shown.reduce((low, value) => Math.min(low, value), 0);
      const up = (value) => (row + 1) * tall - 3 - (tall - 20) * (Math.min(value, high) - low) / (high - low);
      on.strokeStyle = colours.grid;
      on.lineWidth = 1;
      line(on, [[0, up(0)], [width, up(0)]]);
      for (const [values, colour] of lines) {
        on.strokeStyle = colour;
        on.lineWidth = 1.3;
        on.beginPath();
        values.forEach((value, index) => { if (Number.isFinite(value)) on.lineTo(at(index), up(value)); });
        on.stroke();
      }
      on.fillStyle = colours.muted;
      on.font = "11px system-ui, sans-serif";
      on.fillText(name + ", up to " + high.toFixed(2), 6, row * tall + 12);
    });
    return picture;
  }

  // Each fault over its ticks: a shade behind the curves, a bar in the lane, and a point up where it begins.
  function drawFaults(on, at, height) {
    on.fillStyle = colours.bad;
    for (const [from, to] of film.faults.spans) {
      const begin = at(from), width = Math.max(1.5, at(to) - begin);
      on.globalAlpha = 0.25;
      on.fillRect(begin - 0.5, 0, width, height - LANE);
      on.globalAlpha = 1;
      on.fillRect(begin - 0.5, height - 4, width, 4);
      on.beginPath();
      for (const [x, y] of [[-5, 0], [5, 0], [0, 4 - LANE]]) on.lineTo(begin + x, height + y);
      on.fill();
    }
  }

  const faultsAt = (index) => film.faults.spans.filter(([from, to]) => from <= index && index <= to).map(([, , word]) => film.faults.words[word]);

  function modeAt(index) {
    let found = "";
    for (const [from, mode] of film.modes) if (from <= index) found = mode;
    return found;
  }

  function read() {
    // No minus before a zero.
    const number = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
    const fixed = (name, digits) => Number.isFinite(of[name][frame]) ? number(of[name][frame], digits) : "–";
    const faults = faultsAt(frame);
    const readings = {
      time: fixed("time", 2), mode: modeAt(frame), fault: faults.join("; ") || "none", speed: fixed("speed", 2), turn: fixed("turn", 2),
      told: fixed("told_speed", 2) + " m/s, " + fixed("told_turn", 2) + " rad/s", gap: fixed("gap", 3),
      took: fixed("took", 2) + (of.took[frame] > film.deadline_ms ? " LATE" : ""),
      admissible: of.samples[frame] > 0 ? of.admissible[frame] + " of " + of.samples[frame] : "–",
      heading: fixed("heading", 3), dist: fixed("dist", 3), vel: fixed("vel", 3), combine: fixed("combine", 3),
      score: fixed("score", 7), path: of.path[frame] + 1 + " of " + film.paths.length,
    };
    for (const [name, text] of Object.entries(readings)) figure.querySelector("[data-reading=" + name + "]").textContent = text;
    figure.querySelector("[data-reading=fault]").classList.toggle("is-fault", faults.length > 0);
    for (const fault of listed) fault.setAttribute("aria-current", Number(fault.dataset.frame) === frame);
    slider.value = frame;
    slider.setAttribute("aria-valuetext", [readings.time + " s", readings.mode, ...faults].join(", "));
  }

  function show(index) {
    frame = Math.max(0, Math.min(last, index));
    draw();
  }

  function setPlaying(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (frame === last) show(0);
    [before, ahead] = [performance.now(), 0];
    requestAnimationFrame(advance);
  }

  // As many frames as the time that went by, at the chosen speed.
  function advance(now) {
    if (!playing) return;
    ahead += (now - before) / 1000 * Number(speed.value);
    before = now;
    let next = frame;
    while (next < last && ahead >= of.time[next + 1] - of.time[next]) {
      ahead -= of.time[next + 1] - of.time[next];
      next++;
    }
    if (next !== frame) show(next);
    if (next === last) return setPlaying(false);
    requestAnimationFrame(advance);
  }

  function step(by) {
    setPlaying(false);
    show(frame + by);
  }

  button.addEventListener("click", () => setPlaying(!playing));
  figure.querySelector("[data-does=back]").addEventListener("click", () => step(-1));
  figure.querySelector("[data-does=forward]").addEventListener("click", () => step(1));
  slider.addEventListener("input", () => { setPlaying(false); show(Number(slider.value)); });
  for (const fault of listed) fault.addEventListener("click", () => { setPlaying(false); show(Number(fault.dataset.frame)); });
  for (const layer of figure.querySelectorAll("[data-layer]")) layer.addEventListener("change", draw);
  stage.addEventListener("keydown", (event) => {
    const does = { " ": () => setPlaying(!playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1), Home: () => step(-last), End: () => step(last) }[event.key];
    if (does) { event.preventDefault(); does(); }
  });
  strip.addEventListener("pointerdown", (event) => {
    const share = (event.offsetX - 4) / (strip.clientWidth - 8);
    setPlaying(false);
    show(Math.round(share * last));
  });
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); draw(); });
  // A page opened at #t=120 begins there.
  const wanted = /^#t=([\d.]+)$/.exec(location.hash);
  show(wanted ? of.time.findLastIndex((time) => time <= Number(wanted[1])) : 0);
}
