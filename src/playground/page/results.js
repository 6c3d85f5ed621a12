// Shows a decision: whether the bits agree, the winner, the terms, the times.

const find = (id) => document.getElementById(id);
const number = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const whole = (value) => value.toLocaleString("en");
const ms = (value) => value === null || value === undefined ? "–" : number(value, 2) + " ms";

const TERMS = [
  ["speed", "m/s", "v", 3], ["turn rate", "rad/s", "omega", 3], ["heading", "rad", "heading", 3], ["clearance", "m", "clearance", 3],
  ["velocity", "m/s", "vel", 3], ["goal's distance", "m", "path", 3], ["score", "", "score", 0],
];
// Until nothing has changed for so long, nothing is said aloud.
const QUIET_MS = 400;
// So many of the last warm decisions make the median.
const KEPT = 31;

const warm = [];
let cold = null, kind = "", saying = 0;

export function setCold(took) {
  cold = took;
}

function median(values) {
  const sorted = [...values].sort((one, other) => one - other);
  return sorted.length ? sorted[Math.floor(sorted.length / 2)] : null;
}

function words(sample, statuses, key, digits) {
  if (!sample) return "–";
  if (key === "score") return sample.score === null ? statuses[sample.status].replace("_", " ") : sample.score.toPrecision(5);
  // One that is not admissible has velocities and no terms.
  return sample.score === null && !["v", "omega"].includes(key) ? "–" : number(sample[key], digits);
}

export function showTerms({ winner }, looked, statuses) {
  const row = ([name, unit, key, digits]) => {
    const line = document.createElement("tr"), head = document.createElement("th");
    Object.assign(head, { scope: "row", textContent: unit ? `${name}, ${unit}` : name });
    const cells = [winner, looked].map((sample) => Object.assign(document.createElement("td"), { textContent: words(sample, statuses, key, digits) }));
    line.dataset.term = key;
    line.append(head, ...cells);
    return line;
  };
  find("terms").replaceChildren(...TERMS.map(row));
  find("looked-words").textContent = looked ? `sample ${looked.index}` : "none";
  find("looked").setAttribute("aria-valuetext", looked ? `sample ${looked.index}, ${words(looked, statuses, "score", 0)}` : "none");
}

// What is shown is of an earlier problem.
export function showStale() {
  find("verdict").className = "badge bad";
  find("verdict").textContent = "not decided";
  find("why").textContent = "This is the decision before it.";
}

export function show(shown, withoutGpu) {
  const { decision, own, verdict, took, isCold, reading, server_ms, counts } = shown;
  // The times of decisions of one size are no guide to those of another.
  const kindNow = JSON.stringify([decision.bytes, decision.horizon_s]);
  if (kind !== kindNow) warm.length = 0;
  kind = kindNow;
  if (took !== undefined && !isCold) {
    warm.push(took);
    if (warm.length > KEPT) warm.shift();
  }
  const badge = find("verdict");
  badge.className = "badge " + { agree: "good", differ: "bad", server: "" }[verdict];
  badge.textContent = { agree: "agree, bit for bit", differ: "differ", server: "server only" }[verdict];
  const adapter = own ? `browser (${own.name}) and ${decision.engine}` : "";
  find("why").textContent = { agree: adapter, differ: shown.difference, server: withoutGpu }[verdict] ?? "";
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
    "server: there and back": ms(server_ms),
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
  say(shown);
}

function say({ winner, counts, verdict }) {
  clearTimeout(saying);
  const checked = { agree: " Browser and CPU agree, bit for bit.", differ: " Browser and CPU differ.", server: " Decided by the server's CPU engine." }[verdict];
  const text = winner
    ? `Winner: sample ${winner.index}, ${number(winner.v, 2)} m/s, ${number(winner.omega, 2)} rad/s, clearance ${number(winner.clearance, 2)} m; ${whole(counts[0])} samples admissible.`
    : "No sample is admissible: the robot stops.";
  find("winner").textContent = text + checked;
  saying = setTimeout(() => { find("told").textContent = text + checked; }, QUIET_MS);
}
