// Takes a decision at each change. The latest decision wins, and drawing never waits for one.
import { Gpu } from "./gpu.js";
import * as evaluation from "./evaluation.js";
import { View } from "./view.js";
import { after, arcOf, draw, mapImage, readColours } from "./drawing.js";
import { Handles, rounded } from "./handles.js";
import { makeControls } from "./controls.js";
import * as results from "./results.js";
import { clearDrive, driveToGoal } from "./drive.js";
import "./copy.js";

const find = (id) => document.getElementById(id);
const [stage, canvas, busy] = [find("stage"), find("canvas"), find("results")];

const setup = await (await fetch("/setup")).json();
const view = new View();
const state = { scene: setup.scenes[0], problem: null, map: null, shown: null, selected: null };
const scenes = new Map();
let colours = readColours(), gpu = null, version = 0, isRunning = false, isDrawn = true, decisions = 0;

// Opening the device takes seconds on some machines: the page shows the server's decision meanwhile.
let isOpening = true, withoutGpu = "WebGPU is being opened. The page shows the decision of the server's CPU engine until then.";

const handles = new Handles(stage, view, () => state.problem, changed, removeObstacle);
const showControls = makeControls(find("sliders"), () => state.problem, changed);

// Fetches cells and field of a scene once.
async function sceneData(scene) {
  if (!scenes.has(scene.name)) {
    const bytes = async (part) => new Uint8Array(await (await fetch(`/scenes/${scene.name}/${part}`)).arrayBuffer());
    const [cells, field] = await Promise.all([bytes("cells"), bytes("field")]);
    scenes.set(scene.name, { cells, field });
  }
  return scenes.get(scene.name);
}

function showError(text) {
  find("error").hidden = !text;
  if (find("error").textContent !== text) find("error").textContent = text;
}

function changed() {
  version += 1;
  busy.setAttribute("aria-busy", "true");
  showControls(setup.limits, state.scene.discs.length);
  drawSoon();
  if (!isRunning) run();
}

async function run() {
  isRunning = true;
  let done = 0;
  while (done < version) {
    done = version;
    busy.dataset.decisions = ++decisions;
    try {
      const problem = structuredClone(state.problem), shown = await decide(problem);
      showError("");
      // The user has selected another scene meanwhile.
      if (problem.map.file !== state.scene.name) continue;
      state.shown = shown;
      showDecision();
    } catch (error) {
      const isGone = error instanceof TypeError;
      results.showStale();
      showError(isGone ? "The server does not answer: check that the program is running." : error.message);
    }
  }
  isRunning = false;
  busy.setAttribute("aria-busy", String(isOpening));
}

async function ask(path, problem, signal) {
  const response = await fetch(path, { signal, method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(problem) });
  if (response.ok) return response;
  throw new Error((await response.json()).error);
}

async function decide(problem) {
  const requested = performance.now();
  const decision = await (await ask("/decision", problem)).json();
  const shown = { problem, decision, server_ms: performance.now() - requested, agreement: "server" };
  let evaluated = evaluation.ofServer(decision);
  let samplesAt = (place) => decision.fan.records.slice(place * evaluation.SAMPLE, (place + 1) * evaluation.SAMPLE);
  const own = gpu && await onGpu(problem, decision).catch(disableGpu);
  if (own) {
    Object.assign(shown, own);
    evaluated = own.evaluated;
    samplesAt = (place) => Array.from(evaluated.samples.subarray(decision.fan.indices[place] * evaluation.SAMPLE, (decision.fan.indices[place] + 1) * evaluation.SAMPLE));
  }
  const inSi = (index, words) => evaluation.inSi(decision, problem, evaluated, index, words);
  const { winner, counts } = evaluated;
  return {
    ...shown, counts,
    winner: winner && inSi(winner.index, [0, ...winner.terms]),
    fan: decision.fan.indices.map((index, place) => inSi(index, samplesAt(place))),
  };
}

// Takes the decision in the browser and compares it with the server's.
async function onGpu(problem, decision) {
  const scene = setup.scenes.find(({ name }) => name === problem.map.file);
  const { field } = await sceneData(scene);
  const { words, took, isCold } = await gpu.decide(decision, scene.name, field);
  const begun = performance.now();
  const records = await gpu.records(decision);
  const reading = performance.now() - begun;
  const evaluated = evaluation.evaluation(words, records, setup.shader, decision);
  // Flips the lowest bit of the path term of the middle sample.
  if (find("flip").checked) evaluated.samples[Math.floor(evaluated.samples.length / evaluation.SAMPLE / 2) * evaluation.SAMPLE + 4] ^= 1;
  const digest = await evaluation.digest(evaluated);
  const own = { own: { digest, name: gpu.name }, evaluated, took, isCold, reading, agreement: "agree" };
  if (digest === decision.cpu.digest) return own;
  const theirs = new Uint32Array(await (await ask("/records", problem)).arrayBuffer());
  return { ...own, agreement: "differ", difference: evaluation.difference(evaluated, evaluation.ofServer(decision), theirs) };
}

// The page continues with the server's decisions.
function disableGpu(error) {
  withoutGpu = `This browser evaluates nothing: ${error.message}. The page shows the decision of the server's CPU engine.`;
  gpu = null;
  return null;
}

// Opens the device, and opens it again after a loss.
async function open() {
  const begun = performance.now();
  gpu = await Gpu.open(setup.shader).catch(disableGpu);
  if (!gpu) return;
  results.setCold(performance.now() - begun);
  gpu.isLost.then((error) => {
    disableGpu(error);
    return open().then(changed);
  });
}

function showDecision() {
  const { shown } = state;
  state.selected = state.selected && (shown.fan.find(({ index }) => index === state.selected.index) ?? null);
  find("selected").max = shown.fan.length - 1;
  results.show(shown, withoutGpu);
  results.showTerms(shown, state.selected, setup.statuses);
  drawSoon();
}

function selectSample(place) {
  state.selected = state.shown?.fan[place] ?? null;
  find("selected").value = place;
  results.showTerms(state.shown, state.selected, setup.statuses);
  drawSoon();
}

// The sample with the arc nearest to a point of the stage.
function nearestTo(screen) {
  const distance = (sample) => Math.min(...arcOf(state.shown.decision, sample).slice(1).map((point) => {
    const [left, top] = view.toScreen(point);
    return Math.hypot(left - screen[0], top - screen[1]);
  }));
  const distances = state.shown.fan.map(distance);
  return distances.indexOf(Math.min(...distances));
}

function drawSoon() {
  if (isDrawn) requestAnimationFrame(drawNow);
  isDrawn = false;
}

function drawNow() {
  isDrawn = true;
  if (!state.problem) return;
  draw(canvas, view, state, colours);
  handles.place();
}

function resize() {
  const width = stage.clientWidth, height = Math.round(Math.min(Math.max(300, width * 0.66), window.innerHeight * 0.72));
  if (width === view.width && height === view.height) return;
  Object.assign(view, { width, height });
  canvas.style.height = height + "px";
  // A fitted view stays fitted, also after a rotation of the screen.
  if (state.problem && view.isFitted) fit();
  drawSoon();
}

function fit() {
  const { robot, target, obstacles } = state.problem;
  view.fit([robot.pose, target, ...obstacles.map(({ x, y }) => [x, y])], 2);
  drawSoon();
}

async function enter(scene) {
  clearDrive();
  state.scene = scene;
  state.problem = structuredClone(scene.problem);
  find("drive").disabled = false;
  state.shown = state.selected = state.map = null;
  const { cells } = await sceneData(scene);
  state.map = mapImage(scene, cells, colours);
  for (const [kind, key] of [[3, "key-closed"], [4, "key-slow"]]) find(key).hidden = !cells.includes(kind);
  fit();
  changed();
}

function removeObstacle(index) {
  state.problem.obstacles.splice(index, 1);
  find("add").focus();
}

function addObstacle() {
  const { obstacles, robot: { pose } } = state.problem;
  // Rows of five ahead of the robot, which move towards it.
  const [x, y, yaw] = after(pose, 2 + 0.8 * Math.floor(obstacles.length / 5), 0, 1), side = 0.7 * (obstacles.length % 5 - 2);
  addObstacleAt([x - side * Math.sin(yaw), y + side * Math.cos(yaw)], yaw + Math.PI);
}

// Adds an obstacle that moves at 0.4 m/s in a direction.
function addObstacleAt([x, y], direction) {
  const { obstacles } = state.problem;
  if (obstacles.length >= setup.limits.obstacles) return showError(`The maximum is ${obstacles.length} obstacles.`);
  obstacles.push({ x: rounded(x), y: rounded(y), radius: 0.3, vx: rounded(0.4 * Math.cos(direction)), vy: rounded(0.4 * Math.sin(direction)) });
  changed();
}

// What a click on the map does, in addition to the selection of a sample.
function clickAt(screen) {
  const at = view.toWorld(screen), { robot } = state.problem;
  const towards = ([x, y]) => Math.atan2(y - at[1], x - at[0]);
  const places = {
    robot: () => { robot.pose = [rounded(at[0]), rounded(at[1]), rounded(towards(state.problem.target))]; changed(); },
    goal: () => { state.problem.target = at.map(rounded); changed(); },
    obstacle: () => addObstacleAt(at, towards(robot.pose)),
  };
  places[find("click").value]?.();
}

// Simulates one tick with the winner's velocity.
function step() {
  const winner = state.shown?.winner, { robot, obstacles } = state.problem, time = 0.1;
  const [v, omega] = winner ? [winner.v, winner.omega] : [0, 0];
  robot.pose = after(robot.pose, v, omega, time);
  robot.velocity = [v, omega];
  for (const obstacle of obstacles) Object.assign(obstacle, { x: obstacle.x + obstacle.vx * time, y: obstacle.y + obstacle.vy * time });
  view.keep(robot.pose);
  changed();
}

function zoom(factor) {
  view.setScale(view.scale * factor);
  drawSoon();
}

function listen() {
  const on = (id, event, does) => find(id).addEventListener(event, does);
  on("scene", "change", (event) => enter(setup.scenes.find(({ name }) => name === event.target.value)));
  on("add", "click", addObstacle);
  on("remove", "click", () => { if (state.problem.obstacles.pop()) changed(); });
  on("step", "click", step);
  on("reset", "click", () => enter(state.scene));
  on("zoom-in", "click", () => zoom(1.4));
  on("zoom-out", "click", () => zoom(1 / 1.4));
  on("fit", "click", fit);
  on("flip", "change", changed);
  on("selected", "input", (event) => selectSample(Number(event.target.value)));
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    if (state.shown) selectSample(nearestTo([event.clientX - box.left, event.clientY - box.top]));
  };
  canvas.addEventListener("pointermove", place);
  canvas.addEventListener("pointerdown", (event) => {
    if (find("click").value === "select") return place(event);
    const box = canvas.getBoundingClientRect();
    clickAt([event.clientX - box.left, event.clientY - box.top]);
  });
  on("drive", "click", () => driveToGoal(structuredClone(state.problem), ask));
  new ResizeObserver(resize).observe(stage);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", async () => {
    colours = readColours();
    state.map = mapImage(state.scene, (await sceneData(state.scene)).cells, colours);
    drawSoon();
  });
}

async function begin() {
  find("scene").append(...setup.scenes.map(({ name, title }) => new Option(title, name)));
  resize();
  listen();
  await Promise.all([enter(state.scene), open()]);
  isOpening = false;
  changed();
}

await begin();
