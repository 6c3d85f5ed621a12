"use strict";
// Decodes the data of a playback. Encoded lists are little-endian, as is every machine that runs a browser.
function readPlayback(figure) {
  const playback = JSON.parse(figure.querySelector(".playback").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);

  // Returns a function from a frame to its discs, five numbers each.
  function discReader({ counts, numbers }) {
    const countOf = new Uint16Array(bytes(counts).buffer), all = floats(numbers);
    const starts = [0];
    for (const count of countOf) starts.push(starts[starts.length - 1] + count);
    return (index) => {
      const discs = [];
      for (let disc = starts[index]; disc < starts[index + 1]; disc++) discs.push(all.subarray(5 * disc, 5 * disc + 5));
      return discs;
    };
  }

  const data = Object.fromEntries(Object.entries(playback.numbers).map(([name, text]) => [name, floats(text)]));
  return {
    ...playback, data, lastFrame: playback.frames - 1,
    ranges: bytes(playback.ranges), scores: bytes(playback.scores),
    moving: discReader(playback.moving), predicted: discReader(playback.predicted),
    // The last frame that is not after a time.
    frameAt: (time) => Math.max(0, data.time.findLastIndex((value) => value <= time)),
  };
}
