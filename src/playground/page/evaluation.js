// Reads the shaders' results, computes their digest, compares evaluations, and converts samples to SI units.

// Number of words of a sample in the digest.
export const SAMPLE = 5;
const NAMES = ["status", "heading", "clearance", "velocity", "path"];

// The evaluation from the words of an answer and of all records.
export function evaluation(answer, records, shader, decision) {
  const at = shader.answer;
  const four = (from) => Array.from(answer.subarray(from, from + 4));
  const [low, high] = [four(at.sums_low), four(at.sums_high)];
  const counts = four(at.counts);
  const score = BigInt.asIntN(64, (BigInt(answer[at.score_high]) << 32n) | BigInt(answer[at.score_low]));
  return {
    counts,
    sums: low.map((part, term) => (BigInt(high[term]) << 32n) | BigInt(part)),
    min: four(at.min),
    max: four(at.max),
    winner: counts[0] > 0 ? { index: answer[at.winner], score, terms: four(at.terms) } : null,
    samples: samples(records, shader, decision),
  };
}

// Five words for each sample. The velocity term of an admissible sample is that of its speed.
function samples(records, { record, record_words }, { velocity_terms }) {
  const count = records.length / record_words;
  const words = new Uint32Array(SAMPLE * count);
  for (let sample = 0; sample < count; sample++) {
    const from = sample * record_words, to = sample * SAMPLE;
    const status = records[from + record.status] & 3;
    words[to] = status;
    words[to + 1] = records[from + record.heading];
    words[to + 2] = records[from + record.clearance];
    words[to + 3] = status === 0 ? velocity_terms[sample % velocity_terms.length] : 0;
    words[to + 4] = records[from + record.path];
  }
  return words;
}

// The evaluation of the server's CPU engine, without samples.
export function ofServer({ cpu }) {
  const winner = cpu.winner && { ...cpu.winner, score: BigInt(cpu.winner.score) };
  return { ...cpu, sums: cpu.sums.map(BigInt), winner };
}

// SHA-256 over all bits, in the same order as the server's digest.
export async function digest({ counts, sums, min, max, winner, samples }) {
  const halves = (wide) => [Number(BigInt.asUintN(32, wide)), Number(BigInt.asUintN(32, wide >> 32n))];
  const best = winner ? [winner.index, ...halves(winner.score), ...winner.terms] : [];
  const head = [...counts, ...sums.flatMap(halves), ...min, ...max, ...best];
  const words = new Uint32Array(head.length + samples.length);
  words.set(head);
  words.set(samples, head.length);
  const hash = await crypto.subtle.digest("SHA-256", words);
  return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

const hex = (value) => "0x" + value.toString(16).padStart(8, "0");

// Describes the first difference between the browser's evaluation and the server's.
export function difference(own, theirs, theirSamples) {
  for (let at = 0; at < theirSamples.length; at++) {
    if (own.samples[at] === theirSamples[at]) continue;
    const [sample, term] = [Math.floor(at / SAMPLE), NAMES[at % SAMPLE]];
    return `sample ${sample}, ${term}: browser ${hex(own.samples[at])}, CPU ${hex(theirSamples[at])}`;
  }
  const parts = (one) => ({ counts: one.counts, sums: one.sums, min: one.min, max: one.max,
    winner: one.winner ? [one.winner.index] : [], score: one.winner ? [one.winner.score] : [], terms: one.winner?.terms ?? [] });
  const [ownParts, theirParts] = [parts(own), parts(theirs)];
  for (const [name, values] of Object.entries(theirParts)) {
    const index = values.findIndex((value, index) => value !== ownParts[name][index]);
    if (index >= 0) return `${name} ${index}: browser ${ownParts[name][index]}, CPU ${values[index]}`;
  }
  return "the digests alone";
}

// The speed and the turn rate of a sample.
export function velocity({ window: { v, omega } }, index) {
  return { v: v[index % v.length], omega: omega[Math.floor(index / v.length)] };
}

// A sample in SI units, with its score (eq. 35).
export function inSi(decision, problem, totals, index, words) {
  const [status, ...terms] = words, { unit, window } = decision, { weights } = problem;
  const signed = [weights.heading, weights.clearance, weights.velocity, -weights.path];
  const share = (value, term) => {
    const min = totals.min[term];
    const [part, whole] = problem.normalization === "minmax" ? [value - min, totals.max[term] - min] : [value, Number(totals.sums[term])];
    return whole === 0 ? 0 : signed[term] * part / whole;
  };
  const units = [unit.heading, unit.clearance, unit.velocity, unit.path];
  const [heading, clearance, vel, path] = terms.map((value, term) => value * units[term]);
  const score = status === 0 ? terms.map(share).reduce((sum, part) => sum + part) : null;
  return { index, status, ...velocity({ window }, index), heading, clearance, vel, path, score };
}
