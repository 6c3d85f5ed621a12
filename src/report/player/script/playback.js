"use strict";
// A playback that grows by parts: a page of a finished drive has one part. Encoded lists are little-endian, as is every machine
// that runs a browser.
function readPlayback(figure) {
  const { part, ...drive } = JSON.parse(figure.querySelector(".playback").textContent);
  const data = { time: new Float32Array() };
  const playback = {
    ...drive, data, lastFrame: -1, shape: "", events: null, modes: [], paths: [], moving: [], predicted: [], sampled: [],
    ranges: new Uint8Array(), scores: new Uint8Array(), faults: { texts: [], spans: [] },
    protection: { title: "", stops: { texts: [], spans: [] }, reductions: { texts: [], spans: [] } },
    // The last frame that is not after a time.
    frameAt: (time) => Math.max(0, data.time.findLastIndex((value) => value <= time)),
    append,
  };

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);

  // The first values of a list, and further ones.
  function joined(list, count, further) {
    const all = new further.constructor(count + further.length);
    all.set(list.subarray(0, count));
    all.set(further, count);
    return all;
  }

  // The discs of each frame, five numbers each.
  function discLists({ counts, numbers }) {
    const all = floats(numbers);
    let begin = 0;
    return Array.from(new Uint16Array(bytes(counts).buffer), (count) => Array.from({ length: count }, () => all.subarray(begin, begin += 5)));
  }

  // Replaces all frames from the first of a part on by its frames.
  function append(part) {
    const { first, beams, trajectories } = part;
    for (const [name, text] of Object.entries(part.numbers)) data[name] = joined(data[name] ?? new Float32Array(), first, floats(text));
    playback.ranges = joined(playback.ranges, first * beams, bytes(part.ranges));
    playback.scores = joined(playback.scores, first * trajectories, bytes(part.scores));
    for (const name of ["moving", "predicted"]) playback[name].splice(first, Infinity, ...discLists(part[name]));
    playback.sampled.splice(first, Infinity, ...part.sampled);
    const { shape, events, paths } = part;
    Object.assign(playback, { beams, trajectories, shape, events, paths, lastFrame: data.time.length - 1 });
    playback.modes = [...playback.modes.filter(([from]) => from < first), ...part.modes];
    if (part.faults) Object.assign(playback, { faults: part.faults, protection: part.protection });
  }

  if (part) append(part);
  return playback;
}
