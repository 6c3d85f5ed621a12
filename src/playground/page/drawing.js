// Draws the ground, the fan and all that stands on the ground.

const NAMES = ["panel", "outside", "ink", "muted", "robot", "command", "path", "moving", "bad", "rock", "unknown", "rock-strength",
  "speed-0", "speed-1", "speed-2", "speed-3"];

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The page's colours now: those of the reader's light or dark.
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  const colours = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  colours.ramp = [0, 1, 2, 3].map((step) => rgb(colours["speed-" + step]));
  return colours;
}

// The ground as a picture of one pixel a cell, lowest row first.
export function groundOf({ width, height }, cells, colours) {
  const picture = new OffscreenCanvas(width, height), on = picture.getContext("2d");
  const image = on.createImageData(width, height), pixels = new Uint32Array(image.data.buffer);
  const pixel = (hex) => rgb(hex).reduce((sum, part, index) => sum + part * 2 ** (8 * index), Math.round(255 * colours["rock-strength"]) * 2 ** 24);
  const kinds = [0, pixel(colours.rock), pixel(colours.unknown)];
  for (let cell = 0; cell < cells.length; cell++) pixels[cell] = kinds[cells[cell]];
  on.putImageData(image, 0, 0);
  return picture;
}

// A colour of the ramp for a share from 0 to 1.
function ramp({ ramp }, share) {
  const place = share * 3, step = Math.min(2, Math.floor(place)), part = place - step;
  return "rgb(" + ramp[step].map((value, index) => Math.round(value + part * (ramp[step + 1][index] - value))).join(" ") + ")";
}

// The pose after driving at constant speed and turn rate.
export function after([x, y, yaw], v, omega, time) {
  const half = omega * time / 2, chord = v * time * (Math.abs(half) < 1e-4 ? 1 : Math.sin(half) / half);
  return [x + chord * Math.cos(yaw + half), y + chord * Math.sin(yaw + half), yaw + omega * time];
}

// The points of an arc over the horizon.
export function arcOf({ from, horizon_s }, { v, omega }) {
  return Array.from({ length: 17 }, (_, part) => after(from, v, omega, part / 16 * horizon_s));
}

// A canvas as fine as the screen.
function prepare(canvas, { width, height }) {
  const fine = window.devicePixelRatio || 1, [wide, tall] = [width * fine, height * fine].map(Math.round);
  if (canvas.width !== wide || canvas.height !== tall) [canvas.width, canvas.height] = [wide, tall];
  const on = canvas.getContext("2d");
  on.setTransform(fine, 0, 0, fine, 0, 0);
  return on;
}

export function draw(canvas, view, { scene, ground, problem, shown, looked }, colours) {
  const on = prepare(canvas, view);
  const line = (points) => {
    on.beginPath();
    for (const point of points) on.lineTo(...view.toScreen(point));
    on.stroke();
  };
  const disc = (point, radius, colour, strength, isFilled = true) => {
    on.globalAlpha = strength;
    on.fillStyle = on.strokeStyle = colour;
    on.beginPath();
    on.arc(...view.toScreen(point), radius * view.scale, 0, 2 * Math.PI);
    if (isFilled) on.fill(); else on.stroke();
    on.globalAlpha = 1;
  };
  on.fillStyle = colours.outside;
  on.fillRect(0, 0, view.width, view.height);
  drawGround(on, view, scene, ground, colours);
  for (const body of problem.obstacles) {
    const horizon = problem.sim_time_s, way = (time) => [body.x + body.vx * time, body.y + body.vy * time];
    for (let part = 1; part <= 4; part++) disc(way(part / 4 * horizon), body.radius, colours.moving, 0.2 - 0.035 * part);
    disc([body.x, body.y], body.radius, colours.moving, 0.6);
    on.strokeStyle = colours.moving;
    on.lineWidth = 2;
    line([[body.x, body.y], view.toWorld(tipOf(view, body))]);
    const [left, top] = tipOf(view, body);
    on.beginPath();
    on.arc(left, top, 4, 0, 2 * Math.PI);
    on.fill();
  }
  if (shown) drawFan(on, shown, looked, colours, line);
  const discs = (pose, strength, isFilled) => {
    const [x, y, yaw] = pose, [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
    for (const part of problem.robot.footprint) disc([x + part.x * cos - part.y * sin, y + part.x * sin + part.y * cos], part.radius, colours.robot, strength, isFilled);
  };
  if (shown?.winner) {
    on.lineWidth = 1.5;
    discs(arcOf(shown.decision, shown.winner).at(-1), 0.6, false);
  }
  drawGoal(on, view.toScreen(problem.target), colours);
  const pose = problem.robot.pose;
  discs(pose, 0.65, true);
  on.strokeStyle = on.fillStyle = colours.ink;
  on.lineWidth = 2;
  const [left, top] = noseOf(view, problem);
  line([pose, view.toWorld([left, top])]);
  on.beginPath();
  on.arc(left, top, 4, 0, 2 * Math.PI);
  on.fill();
}

function drawGround(on, view, { origin: [x, y, yaw], resolution_m, width, height }, ground, colours) {
  if (!ground) return;
  const cell = resolution_m * view.scale, [cos, sin] = [cell * Math.cos(yaw), cell * Math.sin(yaw)];
  on.save();
  on.transform(cos, -sin, -sin, -cos, ...view.toScreen([x, y]));
  on.fillStyle = colours.panel;
  on.fillRect(0, 0, width, height);
  on.imageSmoothingEnabled = cell < 3;
  on.drawImage(ground, 0, 0);
  on.restore();
}

function drawFan(on, { decision, fan, winner }, looked, colours, line) {
  const scores = fan.map(({ score }) => score).filter((score) => score !== null);
  const [worst, best] = [Math.min(...scores), Math.max(...scores)];
  on.lineWidth = 1.3;
  // The best ones last, so that they lie above the others.
  for (const sample of [...fan].sort((one, other) => (one.score ?? -Infinity) - (other.score ?? -Infinity))) {
    on.globalAlpha = sample.score === null ? 0.18 : 0.9;
    on.strokeStyle = sample.score === null ? colours.bad : ramp(colours, best > worst ? (sample.score - worst) / (best - worst) : 1);
    line(arcOf(decision, sample));
  }
  on.globalAlpha = 1;
  if (winner) {
    on.strokeStyle = colours.command;
    on.lineWidth = 4;
    line(arcOf(decision, winner));
  }
  if (looked) {
    on.strokeStyle = colours.ink;
    on.lineWidth = 2;
    on.setLineDash([6, 4]);
    line(arcOf(decision, looked));
    on.setLineDash([]);
  }
}

function drawGoal(on, [left, top], colours) {
  on.strokeStyle = colours.path;
  on.fillStyle = colours.panel;
  on.lineWidth = 3;
  on.beginPath();
  on.arc(left, top, 9, 0, 2 * Math.PI);
  on.fill();
  on.stroke();
  on.fillStyle = colours.path;
  on.beginPath();
  on.arc(left, top, 3, 0, 2 * Math.PI);
  on.fill();
}

// Pixels from an obstacle's centre to where its arrow begins to tell its speed.
const ARROW = 26;

// Where the arrow of an obstacle ends: as far beyond its beginning as it comes in a second.
export function tipOf(view, { x, y, vx, vy }) {
  const speed = Math.hypot(vx, vy), [cos, sin] = speed > 0 ? [vx / speed, vy / speed] : [1, 0];
  const [left, top] = view.toScreen([x, y]), way = ARROW + speed * view.scale;
  return [left + way * cos, top - way * sin];
}

// The velocity of an obstacle whose arrow ends there.
export function velocityOf(view, { x, y }, [left, top]) {
  const from = view.toScreen([x, y]), [right, up] = [left - from[0], from[1] - top], way = Math.hypot(right, up);
  const speed = Math.max(0, way - ARROW) / view.scale;
  return way > 0 ? [speed * right / way, speed * up / way] : [0, 0];
}

// Where the robot's heading line ends.
export function noseOf(view, { robot: { pose: [x, y, yaw] } }) {
  const [left, top] = view.toScreen([x, y]), way = Math.max(34, 0.75 * view.scale);
  return [left + way * Math.cos(yaw), top - way * Math.sin(yaw)];
}
