// Handles to move the robot, the goal and the obstacles by pointer or keys: a button for each.
import { headingTip, velocityTip, velocityOf } from "./drawing.js";

const [FINE_M, COARSE_M, FINE_RAD, COARSE_RAD, SPEED] = [0.05, 0.5, 0.05, 0.5, 0.1];
const MAX_SPEED = 5;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const fixed = (value, digits = 2) => value.toFixed(digits);
export const rounded = (value) => Math.round(value * 1e4) / 1e4;
const wrapped = (angle) => rounded(Math.atan2(Math.sin(angle), Math.cos(angle)));

// The handles of a problem. A handle of a direction or a speed is for the pointer only: keys change it on the main handle.
function handlesOf(problem, view, remove) {
  const { robot } = problem, [x, y, yaw] = robot.pose;
  const list = [{
    key: "robot", label: `robot at ${fixed(x)}, ${fixed(y)} m, facing ${fixed(yaw)} rad`, at: [x, y],
    move: ([x, y]) => { robot.pose = [x, y, robot.pose[2]]; },
    turn: (by) => { robot.pose[2] = wrapped(robot.pose[2] + by); },
  }, {
    key: "heading", at: view.toWorld(headingTip(view, problem)),
    move: ([left, up]) => { robot.pose[2] = wrapped(Math.atan2(up - robot.pose[1], left - robot.pose[0])); },
  }, {
    key: "goal", label: `goal at ${fixed(problem.target[0])}, ${fixed(problem.target[1])} m`, at: problem.target,
    move: (point) => { problem.target = point; },
  }];
  problem.obstacles.forEach((obstacle, index) => {
    const speed = Math.hypot(obstacle.vx, obstacle.vy);
    list.push({
      key: "obstacle " + index, label: `obstacle ${index + 1} at ${fixed(obstacle.x)}, ${fixed(obstacle.y)} m, ${fixed(speed)} m/s`, at: [obstacle.x, obstacle.y],
      move: ([x, y]) => Object.assign(obstacle, { x, y }),
      turn: (by) => {
        const angle = Math.atan2(obstacle.vy, obstacle.vx) + by;
        Object.assign(obstacle, { vx: rounded(speed * Math.cos(angle)), vy: rounded(speed * Math.sin(angle)) });
      },
      accelerate: (by) => {
        const [angle, next] = [Math.atan2(obstacle.vy, obstacle.vx), Math.min(MAX_SPEED, Math.max(0, speed + by))];
        Object.assign(obstacle, { vx: rounded(next * Math.cos(angle)), vy: rounded(next * Math.sin(angle)) });
      },
      remove: () => remove(index),
    }, {
      key: "velocity " + index, at: view.toWorld(velocityTip(view, obstacle)),
      move: (_, screen) => {
        const [vx, vy] = velocityOf(view, obstacle, screen), over = Math.max(1, Math.hypot(vx, vy) / MAX_SPEED);
        Object.assign(obstacle, { vx: rounded(vx / over), vy: rounded(vy / over) });
      },
    });
  });
  return list;
}

export class Handles {
  // `problem` returns the current problem; `changed` is called after each move.
  constructor(stage, view, problem, changed, remove) {
    Object.assign(this, { stage, view, problem, changed, remove, buttons: new Map(), list: [] });
  }

  // Moves the buttons to their positions.
  place() {
    this.list = handlesOf(this.problem(), this.view, this.remove);
    const keys = new Set(this.list.map(({ key }) => key));
    for (const [key, button] of this.buttons) {
      if (keys.has(key)) continue;
      button.remove();
      this.buttons.delete(key);
    }
    for (const { key, label, at } of this.list) {
      const button = this.buttons.get(key) ?? this.make(key, label);
      const [left, top] = this.view.toScreen(at);
      button.style.transform = `translate(${left}px, ${top}px)`;
      if (label) button.setAttribute("aria-label", label);
    }
  }

  find(key) {
    return this.list.find((handle) => handle.key === key);
  }

  make(key, label) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", className: label ? "handle" : "handle part" });
    button.dataset.handle = key;
    if (!label) {
      button.tabIndex = -1;
      button.setAttribute("aria-hidden", "true");
    }
    this.stage.append(button);
    this.buttons.set(key, button);
    let grabOffset = null;
    button.addEventListener("pointerdown", (event) => {
      const [left, top] = this.view.toScreen(this.find(key).at), box = this.stage.getBoundingClientRect();
      grabOffset = [event.clientX - box.left - left, event.clientY - box.top - top];
      button.setPointerCapture(event.pointerId);
    });
    button.addEventListener("pointermove", (event) => {
      if (!grabOffset) return;
      const box = this.stage.getBoundingClientRect(), { width, height } = this.view;
      const screen = [Math.min(width, Math.max(0, event.clientX - box.left - grabOffset[0])), Math.min(height, Math.max(0, event.clientY - box.top - grabOffset[1]))];
      this.find(key).move(this.view.toWorld(screen).map(rounded), screen);
      this.changed();
    });
    for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => { grabOffset = null; });
    button.addEventListener("keydown", (event) => this.press(event, this.find(key)));
    return button;
  }

  press(event, handle) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const step = event.shiftKey ? COARSE_M : FINE_M, angle = event.shiftKey ? COARSE_RAD : FINE_RAD;
    const direction = ARROWS[event.key];
    const action = direction ? () => {
      const point = [0, 1].map((axis) => rounded(handle.at[axis] + direction[axis] * step));
      handle.move(point);
      this.view.keep(point);
    } : {
      q: () => handle.turn?.(angle), e: () => handle.turn?.(-angle),
      "+": () => handle.accelerate?.(SPEED), "=": () => handle.accelerate?.(SPEED), "-": () => handle.accelerate?.(-SPEED),
      Delete: () => handle.remove?.(), Backspace: () => handle.remove?.(),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
    this.changed();
  }
}
