// Draws the map, the trajectory fan, the robot, the goal and the obstacles.

const NAMES = ["panel", "outside", "ink", "muted", "robot", "command", "path", "moving", "bad", "rock", "unknown", "rock-strength",
  "escaping", "speed-0", "speed-1", "speed-2", "speed-3"];

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The current colours of the page, light or dark.
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  const colours = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  colours.ramp = [0, 1, 2, 3].map((step) => rgb(colours["speed-" + step]));
  return colours;
}

// The map as an image with a pixel for each cell, lowest row first.
export function mapImage({ width, height }, cells, colours) {
  const picture = new OffscreenCanvas(width, height), context = picture.getContext("2d");
  const image = context.createImageData(width, height), pixels = new Uint32Array(image.data.buffer);
  const pixel = (hex, strength) => rgb(hex).reduce((sum, part, index) => sum + part * 2 ** (8 * index), Math.round(255 * strength) * 2 ** 24);
  const strength = colours["rock-strength"];
  // Free, occupied, unknown, in a closed zone, with a speed limit.
  const kinds = [0, pixel(colours.rock, strength), pixel(colours.unknown, strength), pixel(colours.bad, 0.3), pixel(colours.escaping, 0.35)];
  for (let cell = 0; cell < cells.length; cell++) pixels[cell] = kinds[cells[cell]];
  context.putImageData(image, 0, 0);
  return picture;
}

// The colour of the ramp for a share from 0 to 1.
function ramp({ ramp }, share) {
  const place = share * 3, step = Math.min(2, Math.floor(place)), part = place - step;
  return "rgb(" + ramp[step].map((value, index) => Math.round(value + part * (ramp[step + 1][index] - value))).join(" ") + ")";
}

// The pose after driving at constant speed and turn rate.
export function after([x, y, yaw], v, omega, time) {
  const half = omega * time / 2, chord = v * time * (Math.abs(half) < 1e-4 ? 1 : Math.sin(half) / half);
  return [x + chord * Math.cos(yaw + half), y + chord * Math.sin(yaw + half), yaw + omega * time];
}

// The points of a sample over the horizon.
export function arcOf({ from, horizon_s, paths }, { index, v, omega }) {
  const path = paths?.[index];
  if (path) return [from.slice(0, 2), ...path];
  return Array.from({ length: 17 }, (_, part) => after(from, v, omega, part / 16 * horizon_s));
}

// Gives the canvas the resolution of the screen.
function prepare(canvas, { width, height }) {
  const fine = window.devicePixelRatio || 1, [wide, tall] = [width * fine, height * fine].map(Math.round);
  if (canvas.width !== wide || canvas.height !== tall) [canvas.width, canvas.height] = [wide, tall];
  const context = canvas.getContext("2d");
  context.setTransform(fine, 0, 0, fine, 0, 0);
  return context;
}

export function draw(canvas, view, { scene, map, problem, shown, selected }, colours) {
  const context = prepare(canvas, view);
  const line = (points) => {
    context.beginPath();
    for (const point of points) context.lineTo(...view.toScreen(point));
    context.stroke();
  };
  const shape = (outline, colour, strength, isFilled = true) => {
    context.globalAlpha = strength;
    context.fillStyle = context.strokeStyle = colour;
    context.beginPath();
    outline();
    if (isFilled) context.fill(); else context.stroke();
    context.globalAlpha = 1;
  };
  const disc = (point, radius, ...style) => shape(() => context.arc(...view.toScreen(point), radius * view.scale, 0, 2 * Math.PI), ...style);
  context.fillStyle = colours.outside;
  context.fillRect(0, 0, view.width, view.height);
  drawMap(context, view, scene, map, colours);
  for (const obstacle of problem.obstacles) {
    const horizon = problem.sim_time_s, position = (time) => [obstacle.x + obstacle.vx * time, obstacle.y + obstacle.vy * time];
    for (let part = 1; part <= 4; part++) disc(position(part / 4 * horizon), obstacle.radius, colours.moving, 0.2 - 0.035 * part);
    disc([obstacle.x, obstacle.y], obstacle.radius, colours.moving, 0.6);
    context.strokeStyle = colours.moving;
    context.lineWidth = 2;
    line([[obstacle.x, obstacle.y], view.toWorld(velocityTip(view, obstacle))]);
    const [left, top] = velocityTip(view, obstacle);
    context.beginPath();
    context.arc(left, top, 4, 0, 2 * Math.PI);
    context.fill();
  }
  if (shown) drawFan(context, shown, selected, colours, line);
  // The polygon of the body, or the discs of a robot without one.
  const robot = ([x, y, yaw], ...style) => {
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)], place = (ahead, left) => [x + ahead * cos - left * sin, y + ahead * sin + left * cos];
    if (!scene.body) return scene.discs.forEach((part) => disc(place(part.x, part.y), part.radius, colours.robot, ...style));
    const outline = () => {
      for (const corner of scene.body) context.lineTo(...view.toScreen(place(...corner)));
      context.closePath();
    };
    shape(outline, colours.robot, ...style);
  };
  if (shown?.winner) {
    context.lineWidth = 1.5;
    robot(arcOf(shown.decision, shown.winner).at(-1), 0.6, false);
  }
  drawGoal(context, view.toScreen(problem.target), colours);
  const pose = problem.robot.pose;
  robot(pose, 0.65);
  context.strokeStyle = context.fillStyle = colours.ink;
  context.lineWidth = 2;
  const [left, top] = headingTip(view, problem);
  line([pose, view.toWorld([left, top])]);
  context.beginPath();
  context.arc(left, top, 4, 0, 2 * Math.PI);
  context.fill();
}

function drawMap(context, view, { origin: [x, y, yaw], resolution_m, width, height }, map, colours) {
  if (!map) return;
  const cell = resolution_m * view.scale, [cos, sin] = [cell * Math.cos(yaw), cell * Math.sin(yaw)];
  context.save();
  context.transform(cos, -sin, -sin, -cos, ...view.toScreen([x, y]));
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, width, height);
  context.imageSmoothingEnabled = cell < 3;
  context.drawImage(map, 0, 0);
  context.restore();
}

function drawFan(context, { decision, fan, winner }, selected, colours, line) {
  const scores = fan.map(({ score }) => score).filter((score) => score !== null);
  const [worst, best] = [Math.min(...scores), Math.max(...scores)];
  context.lineWidth = 1.3;
  // The best arcs last, above the others.
  for (const sample of [...fan].sort((one, other) => (one.score ?? -Infinity) - (other.score ?? -Infinity))) {
    context.globalAlpha = sample.score === null ? 0.18 : 0.9;
    context.strokeStyle = sample.score === null ? colours.bad : ramp(colours, best > worst ? (sample.score - worst) / (best - worst) : 1);
    line(arcOf(decision, sample));
  }
  context.globalAlpha = 1;
  if (winner) {
    context.strokeStyle = colours.command;
    context.lineWidth = 4;
    line(arcOf(decision, winner));
  }
  if (selected) {
    context.strokeStyle = colours.ink;
    context.lineWidth = 2;
    context.setLineDash([6, 4]);
    line(arcOf(decision, selected));
    context.setLineDash([]);
  }
}

function drawGoal(context, [left, top], colours) {
  context.strokeStyle = colours.path;
  context.fillStyle = colours.panel;
  context.lineWidth = 3;
  context.beginPath();
  context.arc(left, top, 9, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
  context.fillStyle = colours.path;
  context.beginPath();
  context.arc(left, top, 3, 0, 2 * Math.PI);
  context.fill();
}

// Length of the arrow of an obstacle at rest, pixels.
const ARROW = 26;

// The tip of an obstacle's arrow: its length grows by the distance of one second.
export function velocityTip(view, { x, y, vx, vy }) {
  const speed = Math.hypot(vx, vy), [cos, sin] = speed > 0 ? [vx / speed, vy / speed] : [1, 0];
  const [left, top] = view.toScreen([x, y]), length = ARROW + speed * view.scale;
  return [left + length * cos, top - length * sin];
}

// The velocity of an obstacle with this tip of its arrow.
export function velocityOf(view, { x, y }, [left, top]) {
  const from = view.toScreen([x, y]), [right, up] = [left - from[0], from[1] - top], length = Math.hypot(right, up);
  const speed = Math.max(0, length - ARROW) / view.scale;
  return length > 0 ? [speed * right / length, speed * up / length] : [0, 0];
}

// The tip of the robot's heading line.
export function headingTip(view, { robot: { pose: [x, y, yaw] } }) {
  const [left, top] = view.toScreen([x, y]), length = Math.max(34, 0.75 * view.scale);
  return [left + length * Math.cos(yaw), top - length * Math.sin(yaw)];
}
