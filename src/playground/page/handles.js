// What is moved by pointer or by keys: a button over each thing on the map.
import { noseOf, tipOf, velocityOf } from "./drawing.js";

const [FINE_M, COARSE_M, FINE_RAD, COARSE_RAD, SPEED] = [0.05, 0.5, 0.05, 0.5, 0.1];
const FASTEST = 5;
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const fixed = (value, digits = 2) => value.toFixed(digits);
const rounded = (value) => Math.round(value * 1e4) / 1e4;
const wrapped = (angle) => rounded(Math.atan2(Math.sin(angle), Math.cos(angle)));

// The handles of a problem. What is a part of another thing is for the pointer only: keys reach it by the thing's own.
function handlesOf(problem, view, remove) {
  const { robot } = problem, [x, y, yaw] = robot.pose;
  const list = [{
    key: "robot", words: `robot at ${fixed(x)}, ${fixed(y)} m, facing ${fixed(yaw)} rad`, at: [x, y],
    move: ([x, y]) => { robot.pose = [x, y, robot.pose[2]]; },
    turn: (by) => { robot.pose[2] = wrapped(robot.pose[2] + by); },
  }, {
    key: "nose", at: view.toWorld(noseOf(view, problem)),
    move: ([left, up]) => { robot.pose[2] = wrapped(Math.atan2(up - robot.pose[1], left - robot.pose[0])); },
  }, {
    key: "goal", words: `goal at ${fixed(problem.target[0])}, ${fixed(problem.target[1])} m`, at: problem.target,
    move: (point) => { problem.target = point; },
  }];
  problem.obstacles.forEach((body, index) => {
    const speed = Math.hypot(body.vx, body.vy);
    list.push({
      key: "obstacle " + index, words: `obstacle ${index + 1} at ${fixed(body.x)}, ${fixed(body.y)} m, ${fixed(speed)} m/s`, at: [body.x, body.y],
      move: ([x, y]) => Object.assign(body, { x, y }),
      turn: (by) => {
        const angle = Math.atan2(body.vy, body.vx) + by;
        Object.assign(body, { vx: rounded(speed * Math.cos(angle)), vy: rounded(speed * Math.sin(angle)) });
      },
      hasten: (by) => {
        const [angle, next] = [Math.atan2(body.vy, body.vx), Math.min(FASTEST, Math.max(0, speed + by))];
        Object.assign(body, { vx: rounded(next * Math.cos(angle)), vy: rounded(next * Math.sin(angle)) });
      },
      remove: () => remove(index),
    }, {
      key: "tip " + index, at: view.toWorld(tipOf(view, body)),
      move: (_, screen) => {
        const [vx, vy] = velocityOf(view, body, screen), over = Math.max(1, Math.hypot(vx, vy) / FASTEST);
        Object.assign(body, { vx: rounded(vx / over), vy: rounded(vy / over) });
      },
    });
  });
  return list;
}

export class Handles {
  // `problem` gives what is shown now; `changed` is told after each move.
  constructor(stage, view, problem, changed, remove) {
    Object.assign(this, { stage, view, problem, changed, remove, buttons: new Map(), list: [] });
  }

  // Puts the buttons where the things are.
  place() {
    this.list = handlesOf(this.problem(), this.view, this.remove);
    const keys = new Set(this.list.map(({ key }) => key));
    for (const [key, button] of this.buttons) {
      if (keys.has(key)) continue;
      button.remove();
      this.buttons.delete(key);
    }
    for (const { key, words, at } of this.list) {
      const button = this.buttons.get(key) ?? this.make(key, words);
      const [left, top] = this.view.toScreen(at);
      button.style.transform = `translate(${left}px, ${top}px)`;
      if (words) button.setAttribute("aria-label", words);
    }
  }

  find(key) {
    return this.list.find((handle) => handle.key === key);
  }

  make(key, words) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", className: words ? "handle" : "handle part" });
    button.dataset.handle = key;
    if (!words) {
      button.tabIndex = -1;
      button.setAttribute("aria-hidden", "true");
    }
    this.stage.append(button);
    this.buttons.set(key, button);
    let grip = null;
    button.addEventListener("pointerdown", (event) => {
      const [left, top] = this.view.toScreen(this.find(key).at), box = this.stage.getBoundingClientRect();
      grip = [event.clientX - box.left - left, event.clientY - box.top - top];
      button.setPointerCapture(event.pointerId);
    });
    button.addEventListener("pointermove", (event) => {
      if (!grip) return;
      const box = this.stage.getBoundingClientRect(), { width, height } = this.view;
      const screen = [Math.min(width, Math.max(0, event.clientX - box.left - grip[0])), Math.min(height, Math.max(0, event.clientY - box.top - grip[1]))];
      this.find(key).move(this.view.toWorld(screen).map(rounded), screen);
      this.changed();
    });
    for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => { grip = null; });
    button.addEventListener("keydown", (event) => this.press(event, this.find(key)));
    return button;
  }

  press(event, handle) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = event.shiftKey ? COARSE_M : FINE_M, angle = event.shiftKey ? COARSE_RAD : FINE_RAD;
    const way = WAYS[event.key];
    const does = way ? () => {
      const point = [0, 1].map((axis) => rounded(handle.at[axis] + way[axis] * step));
      handle.move(point);
      this.view.keep(point);
    } : {
      q: () => handle.turn?.(angle), e: () => handle.turn?.(-angle),
      "+": () => handle.hasten?.(SPEED), "=": () => handle.hasten?.(SPEED), "-": () => handle.hasten?.(-SPEED),
      Delete: () => handle.remove?.(), Backspace: () => handle.remove?.(),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!does) return;
    event.preventDefault();
    does();
    this.changed();
  }
}
