// Heights of the timeline, pixels: a strip chart, its title, the time axis, the lane of the protective layer (its title and its
// bars), and the lane of the faults.
const STRIP_HEIGHT = 78, STRIP_TITLE = 17, TIME_AXIS = 18, PROTECTION_LANE = 28, FAULT_LANE = 12;

// Width of the tick labels, and margin at the right, pixels.
const LABEL_WIDTH = 44, RIGHT_MARGIN = 10;

// Gap up to which the strip chart reaches, metres. Farther obstacles do not matter, and would flatten the curve.
const MAX_GAP_M = 3;

// The strip charts of the whole drive, with the values at the selected or hovered frame.
function createTimeline(canvas, playback, onSelect) {
  const { data } = playback;
  const newStrips = () => [
    linearStrip("speed", "m/s", [["true", "speed", "robot"], ["command", "commanded_speed", "command"]], Infinity),
    linearStrip("turn rate", "rad/s", [["true", "turn_rate", "robot"], ["command", "commanded_turn_rate", "command"]], Infinity),
    linearStrip("gap", "m", [["", "gap", "gap"]], MAX_GAP_M),
    logarithmicStrip("decision time", "ms", [["", "decision_time", "latency"]], playback.deadline_ms),
  ];
  let strips = newStrips();
  const stripsHeight = strips.length * STRIP_HEIGHT, height = stripsHeight + TIME_AXIS + PROTECTION_LANE + FAULT_LANE;
  let image = null, hovered = null, redraw = () => {};

  function finiteValues(curves) {
    return curves.flatMap(([, name]) => Array.from(data[name] ?? []).filter(Number.isFinite));
  }

  // A strip whose scale has the value zero. Values above `cap` are drawn at it.
  function linearStrip(name, unit, curves, cap) {
    const values = finiteValues(curves);
    const most = Math.min(cap, values.reduce((most, value) => Math.max(most, value), 0.1));
    const least = values.reduce((least, value) => Math.min(least, value), 0);
    const step = roundNumberAbove((most - least) / 3);
    const [first, last] = [Math.floor(least / step + 1e-9), Math.ceil(most / step - 1e-9)];
    const [low, high] = [first * step, last * step];
    const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
    const ticks = Array.from({ length: last - first + 1 }, (_, index) => (first + index) * step);
    const isCut = values.some((value) => value > high);
    return {
      title: name + ", " + unit + (isCut ? ", drawn up to " + high : ""), curves,
      ticks: ticks.map((value) => [value, number(value, digits)]),
      share: (value) => (Math.min(value, high) - low) / (high - low),
    };
  }

  // A strip for positive values over many decades, with a limit.
  function logarithmicStrip(name, unit, curves, limit) {
    const values = finiteValues(curves).filter((value) => value > 0);
    const most = Math.max(limit, values.reduce((most, value) => Math.max(most, value), limit));
    const least = values.reduce((least, value) => Math.min(least, value), most / 10);
    const [low, high] = [Math.floor(Math.log10(least)), Math.ceil(Math.log10(most) - 1e-9)];
    const stride = Math.ceil((high - low) / 4), ticks = [];
    for (let decade = high; decade >= low; decade -= stride) ticks.push([10 ** decade, String(Number((10 ** decade).toPrecision(1)))]);
    return {
      title: name + ", " + unit, curves, ticks, limit,
      share: (value) => value > 0 ? Math.max(0, (Math.log10(value) - low) / (high - low)) : NaN,
    };
  }

  // A strip maps its share from the line above the next strip to the line below its title.
  const stripY = (row, share) => (row + 1) * STRIP_HEIGHT - 5 - (STRIP_HEIGHT - STRIP_TITLE - 8) * share;
  const frameToX = (width) => {
    const begin = data.time[0], duration = data.time[playback.lastFrame] - begin || 1;
    return (index) => LABEL_WIDTH + (width - LABEL_WIDTH - RIGHT_MARGIN) * (data.time[Math.min(index, playback.lastFrame)] - begin) / duration;
  };
  function frameAtX(x) {
    const share = (x - LABEL_WIDTH) / (canvas.clientWidth - LABEL_WIDTH - RIGHT_MARGIN);
    const [begin, end] = [data.time[0], data.time[playback.lastFrame]], half = (end - begin) / Math.max(1, playback.lastFrame) / 2;
    return playback.frameAt(begin + Math.max(0, Math.min(1, share)) * (end - begin) + half);
  }

  // The curves are drawn once for each size and theme; the line and the values at a frame are drawn over them.
  function draw(frame, colours) {
    const { context, width } = prepareCanvas(canvas, height);
    const size = width + " " + window.devicePixelRatio;
    if (!image || image.size !== size || image.colours !== colours) {
      image = { size, colours, ...drawCurves(width, colours) };
    }
    context.drawImage(image.layer, 0, 0, width, height);
    drawCursor(context, width, frame, colours.ink, 1.5);
    if (hovered !== null && hovered !== frame) drawCursor(context, width, hovered, colours.muted, 1);
    drawValues(context, width, hovered ?? frame, colours);
    redraw = () => draw(frame, colours);
  }

  // A line at a frame through all strips and lanes; it leaves the titles of the strips free.
  function drawCursor(context, width, frame, colour, lineWidth) {
    const x = frameToX(width)(frame);
    context.strokeStyle = colour;
    context.lineWidth = lineWidth;
    strips.forEach((_, row) => drawLine(context, [[x, row * STRIP_HEIGHT + STRIP_TITLE], [x, (row + 1) * STRIP_HEIGHT]]));
    drawLine(context, [[x, stripsHeight + TIME_AXIS], [x, height]]);
  }

  // The values of all curves next to the titles, and the time on the axis.
  function drawValues(context, width, frame, colours) {
    context.font = "600 11px system-ui, sans-serif";
    strips.forEach((strip, row) => {
      let x = LABEL_WIDTH + image.titleWidths[row] + 12;
      for (const [label, name, colour] of strip.curves) {
        const value = data[name][frame];
        const text = (label ? label + " " : "") + (Number.isFinite(value) ? number(value, 2) : "–");
        drawLabel(context, text, x, row * STRIP_HEIGHT + 12, colours[colour], colours.panel);
        x += context.measureText(text).width + 12;
      }
    });
    drawTimes(context, width, frame, colours);
  }

  // The time of a frame on the axis, and the ticks that it leaves space for.
  function drawTimes(context, width, frame, colours) {
    const text = data.time[frame].toFixed(2) + " s", half = context.measureText(text).width / 2;
    const x = Math.max(LABEL_WIDTH + half, Math.min(width - half - 2, frameToX(width)(frame))), y = stripsHeight + 13;
    context.textAlign = "center";
    drawLabel(context, text, x, y, colours.ink, colours.panel);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = colours.muted;
    for (const [tickX, label] of timeTicks(width)) {
      const reach = context.measureText(label).width / 2;
      if (Math.abs(tickX - x) > half + reach + 4 && tickX + reach < width) context.fillText(label, tickX, y);
    }
    context.textAlign = "left";
  }

  // Position and label of each tick of the time axis.
  function timeTicks(width) {
    const [begin, end] = [data.time[0], data.time[playback.lastFrame]], toX = frameToX(width), ticks = [];
    const step = roundNumberAbove(Math.max(0.1, (end - begin) / Math.max(2, Math.floor(width / 70))));
    for (let time = Math.ceil(begin / step) * step; time <= end + 1e-6; time += step) {
      ticks.push([toX(playback.frameAt(time + 1e-3)), Number(time.toPrecision(6)) + " s"]);
    }
    return ticks;
  }

  function drawCurves(width, colours) {
    const layer = document.createElement("canvas"), toX = frameToX(width);
    [layer.width, layer.height] = [canvas.width, canvas.height];
    const context = layer.getContext("2d");
    context.scale(canvas.width / width, canvas.height / height);
    context.font = "11px system-ui, sans-serif";
    drawTimeGrid(context, width, colours);
    drawFaults(context, toX, colours);
    drawProtection(context, toX, colours);
    strips.forEach((strip, row) => drawStrip(context, strip, row, width, toX, colours));
    return { layer, titleWidths: strips.map((strip) => context.measureText(strip.title).width) };
  }

  function drawStrip(context, strip, row, width, toX, colours) {
    const toY = (value) => stripY(row, strip.share(value));
    context.lineWidth = 1;
    context.textAlign = "right";
    for (const [value, label] of strip.ticks) {
      const y = Math.round(toY(value)) + 0.5;
      context.strokeStyle = value === 0 ? colours.muted : colours.grid;
      drawLine(context, [[LABEL_WIDTH, y], [width - RIGHT_MARGIN, y]]);
      context.fillStyle = colours.muted;
      context.fillText(label, LABEL_WIDTH - 5, y + 3.5);
    }
    context.textAlign = "left";
    for (const [, name, colour] of strip.curves) {
      context.strokeStyle = colours[colour];
      context.lineWidth = 1.3;
      context.beginPath();
      data[name].forEach((value, index) => {
        const y = toY(value);
        if (Number.isFinite(y)) context.lineTo(toX(index), y);
      });
      context.stroke();
    }
    if (strip.limit) drawLimit(context, row, toY(strip.limit), width, colours);
    drawLabel(context, strip.title, LABEL_WIDTH, row * STRIP_HEIGHT + 12, colours.muted, colours.panel);
  }

  // The control period is the limit of a decision. Its name stands next to the title, where no curve crosses it.
  function drawLimit(context, row, y, width, colours) {
    const text = "control period " + Number(playback.deadline_ms.toPrecision(3)) + " ms", titleY = row * STRIP_HEIGHT + 12;
    const right = width - RIGHT_MARGIN, left = right - context.measureText(text).width;
    context.fillStyle = colours.ink;
    context.fillText(text, left, titleY);
    context.strokeStyle = colours.ink;
    context.lineWidth = 1.2;
    context.setLineDash([6, 4]);
    drawLine(context, [[LABEL_WIDTH, y], [right, y]]);
    drawLine(context, [[left - 20, titleY - 4], [left - 4, titleY - 4]]);
    context.setLineDash([]);
  }

  function drawTimeGrid(context, width, colours) {
    context.strokeStyle = colours.grid;
    context.lineWidth = 1;
    for (const [x] of timeTicks(width)) drawLine(context, [[x, 0], [x, stripsHeight]]);
  }

  // Shades the ticks of each fault behind the curves, and draws a bar with a triangle at its first tick in the lane.
  function drawFaults(context, toX, colours) {
    context.fillStyle = colours.bad;
    for (const [from, to] of playback.faults.spans) {
      const left = toX(from), width = Math.max(1.5, toX(to) - left);
      context.globalAlpha = 0.25;
      context.fillRect(left - 0.5, 0, width, height - FAULT_LANE);
      context.globalAlpha = 1;
      context.fillRect(left - 0.5, height - 4, width, 4);
      context.beginPath();
      for (const [x, y] of [[-5, 0], [5, 0], [0, 4 - FAULT_LANE]]) context.lineTo(left + x, height + y);
      context.fill();
    }
  }

  // Draws a bar for each action of the protective layer: a high one for a stop, a low one for a reduced command.
  function drawProtection(context, toX, colours) {
    const { title, stops, reductions } = playback.protection, bottom = height - FAULT_LANE;
    context.fillStyle = colours.latency;
    for (const [events, barHeight] of [[reductions, 5], [stops, 11]]) {
      for (const [from, to] of events.spans) {
        const left = toX(from), width = Math.max(1.5, toX(to) - left);
        context.fillRect(left - 0.5, bottom - 2 - barHeight, width, barHeight);
      }
    }
    drawLabel(context, title, LABEL_WIDTH, bottom - PROTECTION_LANE + 12, colours.muted, colours.panel);
  }

  function hover(frame) {
    hovered = frame;
    redraw();
  }

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    onSelect(frameAtX(event.offsetX));
  });
  canvas.addEventListener("pointermove", (event) => {
    const frame = frameAtX(event.offsetX);
    if (event.buttons) onSelect(frame);
    hover(event.buttons ? null : frame);
  });
  canvas.addEventListener("pointerleave", () => hover(null));
  // Fits the strips to more frames.
  function rescale() {
    strips = newStrips();
    image = null;
  }

  return { draw, rescale };
}

// Returns a number as text. Zero has no minus sign.
function number(value, digits) {
  return (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
}
