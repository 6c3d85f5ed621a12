// Sliders and selections for the settings of a problem.

const COUNTS = [1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48, 64, 96, 128, 192, 256, 384, 512];

const whole = (value) => value.toLocaleString("en");
const of = (unit, digits) => (value) => value.toFixed(digits) + unit;

// Id, label, location in the problem, values or range, and text of a value.
const SLIDERS = [
  ["vx_samples", "forward speeds", (problem) => [problem, "vx_samples"], { values: COUNTS }, whole],
  ["vtheta_samples", "turn rates", (problem) => [problem, "vtheta_samples"], { values: [...COUNTS, 768, 1024] }, whole],
  ["sim_time_s", "horizon", (problem) => [problem, "sim_time_s"], { min: 0.5, max: 8, step: 0.1 }, of(" s", 1)],
  ["control_period_s", "window", (problem) => [problem, "control_period_s"], { min: 0.1, max: 2, step: 0.1 }, of(" s", 1)],
  ["v", "speed now", (problem) => [problem.robot.velocity, 0], ({ limits }) => ({ min: limits.min_vel_x, max: limits.max_vel_x, step: 0.05 }), of(" m/s", 2)],
  ["omega", "turn rate now", (problem) => [problem.robot.velocity, 1], ({ limits }) => ({ min: -limits.max_vel_theta, max: limits.max_vel_theta, step: 0.05 }), of(" rad/s", 2)],
  ["heading", "weight of heading", (problem) => [problem.weights, "heading"], { min: 0, max: 1, step: 0.01 }, of("", 2)],
  ["clearance", "weight of clearance", (problem) => [problem.weights, "clearance"], { min: 0, max: 1, step: 0.01 }, of("", 2)],
  ["velocity", "weight of velocity", (problem) => [problem.weights, "velocity"], { min: 0, max: 1, step: 0.01 }, of("", 2)],
  ["path", "weight of the goal's distance", (problem) => [problem.weights, "path"], { min: 0, max: 1, step: 0.01 }, of("", 2)],
];
const CHOICES = [
  ["sampler", "samples are", [["arcs", "arcs"], ["ramps", "ramps"], ["two_segments", "two segments"], ["sequences", "sequences"]]],
  ["normalization", "normalised by", [["sum", "the sum"], ["minmax", "least and greatest"]]],
  ["stopping", "must stop within", [["clearance", "its clearance"], ["arc", "the arc left"]]],
];

function element(name, parts = {}, ...children) {
  const made = Object.assign(document.createElement(name), parts);
  made.append(...children);
  return made;
}

// Adds controls to the box. They change the problem that `problem` returns, and call `changed`. Returns a function that shows the
// current values, for a robot of this number of discs.
export function makeControls(box, problem, changed) {
  const shows = [...SLIDERS.map((slider) => makeSlider(box, problem, changed, slider)), ...CHOICES.map((choice) => makeChoice(box, problem, changed, choice))];
  const product = element("p", { className: "limits" });
  box.append(product);
  return (limits, discs) => {
    for (const show of shows) show();
    const { vx_samples, vtheta_samples, sim_time_s, sim_step_s, obstacles } = problem();
    const samples = vx_samples * vtheta_samples, steps = Math.round(sim_time_s / sim_step_s);
    const discChecks = samples * steps * discs * (1 + obstacles.length);
    product.textContent = `${whole(vx_samples)} × ${whole(vtheta_samples)} = ${whole(samples)} samples of ${steps} steps, ` +
      `${obstacles.length} obstacles: at most ${whole(limits.samples)} samples, ${limits.obstacles} obstacles. ` +
      `Samples × steps × discs × (1 + obstacles) = ${whole(discChecks)}: at most ${whole(limits.disc_checks)}.`;
  };
}

function makeSlider(box, problem, changed, [id, name, place, range, words]) {
  const output = element("output", { htmlFor: id }), input = element("input", { type: "range", id });
  box.append(element("label", { className: "slider" }, element("span", { textContent: name }), output, input));
  const rangeNow = () => typeof range === "function" ? range(problem()) : range;
  input.addEventListener("input", () => {
    const { values } = rangeNow(), [of, key] = place(problem());
    of[key] = values ? values[Number(input.value)] : Number(input.value);
    changed();
  });
  return () => {
    const { values, min, max, step } = rangeNow(), [of, key] = place(problem()), value = of[key];
    Object.assign(input, values ? { min: 0, max: values.length - 1, step: 1 } : { min, max, step });
    // A value between two steps of the slider stays until the slider is moved.
    input.value = values ? values.findLastIndex((one) => one <= value) : value;
    output.textContent = words(value);
    input.setAttribute("aria-valuetext", words(value));
  };
}

function makeChoice(box, problem, changed, [key, name, options]) {
  const select = element("select", { id: key }, ...options.map(([value, textContent]) => element("option", { value, textContent })));
  box.append(element("label", { className: "choice" }, element("span", { textContent: name }), select));
  select.addEventListener("change", () => {
    problem()[key] = select.value;
    changed();
  });
  return () => { select.value = problem()[key]; };
}
