// Takes a decision at each change: the latest wins, and nothing that is drawn waits for it.
import { Gpu } from "./gpu.js";
import * as answer from "./evaluation.js";
import { View } from "./view.js";
import { after, arcOf, draw, groundOf, readColours } from "./drawing.js";
import { Handles } from "./handles.js";
import { makeControls } from "./controls.js";
import * as results from "./results.js";

const find = (id) => document.getElementById(id);
const [stage, canvas, busy] = [find("stage"), find("canvas"), find("results")];

const setup = await (await fetch("/setup")).json();
const view = new View();
const state = { scene: setup.scenes[0], problem: null, ground: null, shown: null, looked: null };
const grounds = new Map();
let colours = readColours(), gpu = null, withoutGpu = "", version = 0, isRunning = false, isDrawn = true, decisions = 0;

const handles = new Handles(stage, view, () => state.problem, changed, removeObstacle);
const showControls = makeControls(find("sliders"), () => state.problem, changed);

// Cells and field of a scene, asked for once.
async function groundFor(scene) {
  if (!grounds.has(scene.name)) {
    const bytes = async (part) => new Uint8Array(await (await fetch(`/scenes/${scene.name}/${part}`)).arrayBuffer());
    const [cells, field] = await Promise.all([bytes("cells"), bytes("field")]);
    grounds.set(scene.name, { cells, field });
  }
  return grounds.get(scene.name);
}

function trouble(text) {
  find("trouble").hidden = !text;
  if (find("trouble").textContent !== text) find("trouble").textContent = text;
}

function changed() {
  version += 1;
  busy.setAttribute("aria-busy", "true");
  showControls(setup.limits);
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
      trouble("");
      // Of a scene that was left meanwhile nothing is shown.
      if (problem.map.file !== state.scene.name) continue;
      state.shown = shown;
      showDecision();
    } catch (error) {
      const isGone = error instanceof TypeError;
      results.showStale();
      trouble(isGone ? "The server does not answer: is the program still running?" : error.message);
    }
  }
  isRunning = false;
  busy.setAttribute("aria-busy", "false");
}

async function ask(path, problem) {
  const response = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(problem) });
  if (response.ok) return response;
  throw new Error((await response.json()).error);
}

async function decide(problem) {
  const asked = performance.now();
  const decision = await (await ask("/decision", problem)).json();
  const shown = { problem, decision, server_ms: performance.now() - asked, verdict: "server" };
  let evaluated = answer.ofServer(decision);
  let samplesAt = (place) => decision.fan.records.slice(place * answer.SAMPLE, (place + 1) * answer.SAMPLE);
  const own = gpu && await onGpu(problem, decision).catch(withoutGpuSince);
  if (own) {
    Object.assign(shown, own);
    evaluated = own.evaluated;
    samplesAt = (place) => Array.from(evaluated.samples.subarray(decision.fan.indices[place] * answer.SAMPLE, (decision.fan.indices[place] + 1) * answer.SAMPLE));
  }
  const inSi = (index, words) => answer.inSi(decision, problem, evaluated, index, words);
  const { winner, counts } = evaluated;
  return {
    ...shown, counts,
    winner: winner && inSi(winner.index, [0, ...winner.terms]),
    fan: decision.fan.indices.map((index, place) => inSi(index, samplesAt(place))),
  };
}

// The browser's own decision, held against the server's.
async function onGpu(problem, decision) {
  const scene = setup.scenes.find(({ name }) => name === problem.map.file);
  const { field } = await groundFor(scene);
  const { words, took, isCold } = await gpu.decide(decision, scene.name, field);
  const begun = performance.now();
  const records = await gpu.records(decision);
  const reading = performance.now() - begun;
  const evaluated = answer.evaluation(words, records, setup.shader, decision);
  // The lowest bit of the path term of the sample in the middle.
  if (find("flip").checked) evaluated.samples[Math.floor(evaluated.samples.length / answer.SAMPLE / 2) * answer.SAMPLE + 4] ^= 1;
  const digest = await answer.digest(evaluated);
  const own = { own: { digest, name: gpu.name }, evaluated, took, isCold, reading, verdict: "agree" };
  if (digest === decision.cpu.digest) return own;
  const theirs = new Uint32Array(await (await ask("/records", problem)).arrayBuffer());
  return { ...own, verdict: "differ", difference: answer.difference(evaluated, answer.ofServer(decision), theirs) };
}

// The page goes on with the server's answers.
function withoutGpuSince(error) {
  withoutGpu = `Nothing is evaluated in this browser: ${error.message}. What you see is the answer of the server's CPU engine.`;
  gpu = null;
  return null;
}

// A device that is lost is opened anew.
async function open() {
  const begun = performance.now();
  gpu = await Gpu.open(setup.shader).catch(withoutGpuSince);
  if (!gpu) return;
  results.setCold(performance.now() - begun);
  gpu.isLost.then((error) => {
    withoutGpuSince(error);
    return open().then(changed);
  });
}

function showDecision() {
  const { shown } = state;
  state.looked = state.looked && (shown.fan.find(({ index }) => index === state.looked.index) ?? null);
  find("looked").max = shown.fan.length - 1;
  results.show(shown, withoutGpu);
  results.showTerms(shown, state.looked, setup.statuses);
  drawSoon();
}

function look(place) {
  state.looked = state.shown?.fan[place] ?? null;
  find("looked").value = place;
  results.showTerms(state.shown, state.looked, setup.statuses);
  drawSoon();
}

// The sample whose arc passes nearest to a place on the stage.
function nearestTo(screen) {
  const away = (sample) => Math.min(...arcOf(state.shown.decision, sample).slice(1).map((point) => {
    const [left, top] = view.toScreen(point);
    return Math.hypot(left - screen[0], top - screen[1]);
  }));
  const ways = state.shown.fan.map(away);
  return ways.indexOf(Math.min(...ways));
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
  // What was fitted stays so, on a phone that is turned too.
  if (state.problem && view.isFitted) fit();
  drawSoon();
}

function fit() {
  const { robot, target, obstacles } = state.problem;
  view.fit([robot.pose, target, ...obstacles.map(({ x, y }) => [x, y])], 2);
  drawSoon();
}

async function enter(scene) {
  state.scene = scene;
  state.problem = structuredClone(scene.problem);
  state.shown = state.looked = state.ground = null;
  const { cells } = await groundFor(scene);
  state.ground = groundOf(scene, cells, colours);
  fit();
  changed();
}

function removeObstacle(index) {
  state.problem.obstacles.splice(index, 1);
  find("add").focus();
}

function addObstacle() {
  const { obstacles, robot: { pose } } = state.problem;
  if (obstacles.length >= setup.limits.obstacles) return trouble(`There are ${obstacles.length} obstacles already.`);
  // Rows of five ahead of the robot, on their way to it.
  const [x, y, yaw] = after(pose, 2 + 0.8 * Math.floor(obstacles.length / 5), 0, 1), side = 0.7 * (obstacles.length % 5 - 2);
  const round = (value) => Math.round(value * 1e4) / 1e4;
  const place = { x: round(x - side * Math.sin(yaw)), y: round(y + side * Math.cos(yaw)) };
  obstacles.push({ ...place, radius: 0.3, vx: round(-0.4 * Math.cos(yaw)), vy: round(-0.4 * Math.sin(yaw)) });
  changed();
}

// The winner is driven for a tick, and all that moves goes on.
function step() {
  const winner = state.shown?.winner, { robot, obstacles } = state.problem, time = 0.1;
  const [v, omega] = winner ? [winner.v, winner.omega] : [0, 0];
  robot.pose = after(robot.pose, v, omega, time);
  robot.velocity = [v, omega];
  for (const body of obstacles) Object.assign(body, { x: body.x + body.vx * time, y: body.y + body.vy * time });
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
  on("closer", "click", () => zoom(1.4));
  on("farther", "click", () => zoom(1 / 1.4));
  on("fit", "click", fit);
  on("flip", "change", changed);
  on("looked", "input", (event) => look(Number(event.target.value)));
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    if (state.shown) look(nearestTo([event.clientX - box.left, event.clientY - box.top]));
  };
  canvas.addEventListener("pointermove", place);
  canvas.addEventListener("pointerdown", place);
  new ResizeObserver(resize).observe(stage);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", async () => {
    colours = readColours();
    state.ground = groundOf(state.scene, (await groundFor(state.scene)).cells, colours);
    drawSoon();
  });
}

async function begin() {
  find("scene").append(...setup.scenes.map(({ name, title }) => new Option(title, name)));
  resize();
  listen();
  await open();
  await enter(state.scene);
}

await begin();
