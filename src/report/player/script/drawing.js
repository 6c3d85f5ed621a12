// What all canvases share: the colours of the page, the resolution of the screen, and lines.

function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["page", "panel", "outside", "ink", "muted", "rule", "grid", "robot", "command", "path", "moving", "bad", "gap",
    "latency", "rock-strength", "speed-0", "speed-1", "speed-2", "speed-3"];
  const colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  colours.ramp = [0, 1, 2, 3].map((step) => rgb(colours["speed-" + step]));
  return colours;
}

// The colour of the ramp at a share from 0 to 1.
function rampColour(colours, share) {
  const position = share * 3, step = Math.min(2, Math.floor(position)), part = position - step;
  const [from, to] = [colours.ramp[step], colours.ramp[step + 1]];
  return "rgb(" + from.map((value, index) => Math.round(value + part * (to[index] - value))).join(" ") + ")";
}

// Gives a canvas the resolution of the screen. Returns its context and its size in CSS pixels.
function prepareCanvas(canvas, height) {
  const width = canvas.clientWidth, ratio = window.devicePixelRatio || 1;
  canvas.style.height = height + "px";
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

function drawLine(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}

function drawDisc(context, x, y, radius, colour, opacity) {
  context.globalAlpha = opacity;
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
  context.globalAlpha = 1;
}

function drawArea(context, corners, colour, opacity) {
  context.globalAlpha = opacity;
  context.fillStyle = colour;
  context.beginPath();
  for (const corner of corners) context.lineTo(...corner);
  context.fill();
  context.globalAlpha = 1;
}

// Writes text that stays readable over lines.
function drawLabel(context, text, x, y, colour, halo) {
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeStyle = halo;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

// The least number that is not below a positive one and is 1, 2 or 5 times a power of ten.
function roundNumberAbove(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  return [1, 2, 5, 10].map((factor) => factor * power).find((number) => number >= value * (1 - 1e-9));
}
