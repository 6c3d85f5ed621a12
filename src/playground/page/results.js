// Shows a decision: agreement of the bits, winner, terms, times.

const find = (id) => document.getElementById(id);
const number = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const whole = (value) => value.toLocaleString("en");
const ms = (value) => value === null || value === undefined ? "–" : number(value, 2) + " ms";

const TERMS = [
  ["speed", "m/s", "v", 3], ["turn rate", "rad/s", "omega", 3], ["heading", "rad", "heading", 3], ["clearance", "m", "clearance", 3],
  ["velocity", "m/s", "vel", 3], ["goal's distance", "m", "path", 3], ["score", "", "score", 0],
];
// Time without a change before the screen reader announces the winner, milliseconds.
const ANNOUNCE_DELAY_MS = 400;
// Number of warm decisions for the median.
const MEDIAN_OF = 31;

const warm = [];
let cold = null, size = "", announcement = 0;

export function setCold(took) {
  cold = took;
}

function median(values) {
  const sorted = [...values].sort((one, other) => one - other);
  return sorted.length ? sorted[Math.floor(sorted.length / 2)] : null;
}

function valueText(sample, statuses, key, digits) {
  if (!sample) return "–";
  if (key === "score") return sample.score === null ? statuses[sample.status].replace("_", " ") : sample.score.toPrecision(5);
  // A sample that is not admissible has no terms.
  return sample.score === null && !["v", "omega"].includes(key) ? "–" : number(sample[key], digits);
}

export function showTerms({ winner }, selected, statuses) {
  const row = ([name, unit, key, digits]) => {
    const line = document.createElement("tr"), head = document.createElement("th");
    Object.assign(head, { scope: "row", textContent: unit ? `${name}, ${unit}` : name });
    const cells = [winner, selected].map((sample) => Object.assign(document.createElement("td"), { textContent: valueText(sample, statuses, key, digits) }));
    line.dataset.term = key;
    line.append(head, ...cells);
    return line;
  };
  find("terms").replaceChildren(...TERMS.map(row));
  find("selected-text").textContent = selected ? `sample ${selected.index}` : "none";
  find("selected").setAttribute("aria-valuetext", selected ? `sample ${selected.index}, ${valueText(selected, statuses, "score", 0)}` : "none");
}

// The page shows the decision of an earlier problem.
export function showStale() {
  clearTimeout(announcement);
  find("winner").textContent = "";
  find("agreement").className = "badge bad";
  find("agreement").textContent = "not decided";
  find("explanation").textContent = "The page shows the previous decision.";
}

export function show(shown, withoutGpu) {
  const { decision, own, agreement, took, isCold, reading, server_ms, counts } = shown;
  // Times of problems of different sizes are not comparable.
  const newSize = JSON.stringify([decision.bytes, decision.horizon_s]);
  if (size !== newSize) warm.length = 0;
  size = newSize;
  if (took !== undefined && !isCold) {
    warm.push(took);
    if (warm.length > MEDIAN_OF) warm.shift();
  }
  const badge = find("agreement");
  badge.className = "badge " + { agree: "good", differ: "bad", server: "" }[agreement];
  badge.textContent = { agree: "agree, bit for bit", differ: "differ", server: "server only" }[agreement];
  const adapter = own ? `browser (${own.name}) and ${decision.engine}` : "";
  find("explanation").textContent = { agree: adapter, differ: shown.difference, server: withoutGpu }[agreement] ?? "";
  find("digest-own").textContent = own?.digest ?? "–";
  find("digest-cpu").textContent = decision.cpu.digest;
  const [admissible, collision, stops, outside] = counts;
  const readings = {
    "browser, last": took === undefined ? "–" : ms(took) + (isCold ? " (cold)" : ""),
    "browser, warm median": warm.length ? `${ms(median(warm))} of ${warm.length}` : "–",
    "browser, cold start": ms(cold),
    "all samples read back": ms(reading),
    "server: preparation": ms(decision.prepare_ms),
    "server: CPU decision": ms(decision.decide_ms),
    "server: round trip": ms(server_ms),
    "admissible": `${whole(admissible)} of ${whole(counts.reduce((sum, count) => sum + count))}`,
    "rejected": `${whole(collision)} collide, ${whole(stops)} cannot stop, ${whole(outside)} leave the map`,
  };
  find("readings").replaceChildren(...Object.entries(readings).map(([name, text]) => {
    const box = document.createElement("div");
    box.dataset.reading = name;
    box.className = name === "rejected" ? "wide" : "";
    box.append(Object.assign(document.createElement("dt"), { textContent: name }), Object.assign(document.createElement("dd"), { textContent: text }));
    return box;
  }));
  announce(shown);
}

function announce({ winner, counts, agreement }) {
  clearTimeout(announcement);
  const checked = { agree: " Browser and CPU agree, bit for bit.", differ: " Browser and CPU differ.", server: " Decided by the server's CPU engine." }[agreement];
  const text = winner
    ? `Winner: sample ${winner.index}, ${number(winner.v, 2)} m/s, ${number(winner.omega, 2)} rad/s, clearance ${number(winner.clearance, 2)} m; ${whole(counts[0])} samples admissible.`
    : "No sample is admissible: the robot stops.";
  find("winner").textContent = text + checked;
  announcement = setTimeout(() => { find("announcement").textContent = text + checked; }, ANNOUNCE_DELAY_MS);
}
