// Time after which the address follows the selected moment, ms. Browsers limit how often an address may change.
const ADDRESS_DELAY_MS = 300;

// Starts the player of a figure. Returns its playback and what else a drive that goes on needs. `onSelect` is called when the user
// selects a time.
function startPlayer(figure, onSelect = () => {}) {
  const find = (selector) => figure.querySelector(selector), action = (name) => find("[data-action=" + name + "]");
  const playback = readPlayback(figure), { data } = playback, section = figure.closest("section");
  const slider = action("seek"), playButton = action("play"), speed = action("speed"), keyHelp = find(".key-help");
  const readings = new Map([...figure.querySelectorAll("[data-reading]")].map((element) => [element.dataset.reading, element]));
  const layers = new Map([...figure.querySelectorAll("[data-layer]")].map((box) => [box.dataset.layer, box]));
  let frame = 0, isPlaying = false, lastUpdate = 0, pendingTime = 0, colours = readColours(), addressTimer = 0;

  const canvas = find(".map-canvas");
  const map = createMap(canvas, playback, loadMapImage(), (layer) => layers.get(layer).checked);
  const view = createView(canvas, playback, action("follow"), () => [data.x[frame], data.y[frame]], () => draw());
  const timeline = createTimeline(find(".timeline"), playback, stopAt);

  // Takes the image of the occupancy grid from the map picture of the same section.
  function loadMapImage() {
    const element = section.querySelector(".map-picture image.ground");
    if (!element) return null;
    const picture = new Image();
    picture.onload = () => draw();
    picture.src = element.getAttribute("href");
    return { picture, transform: element.getAttribute("transform").match(/-?[\d.]+/g).map(Number) };
  }

  function draw() {
    // Nothing is shown on paper, where the window changes its size too, and before the first tick.
    if (canvas.clientWidth === 0 || playback.lastFrame < 0) return;
    map.draw(view, frame, colours);
    timeline.draw(frame, colours);
    updateReadings();
  }

  // The texts of the events at a frame.
  function textsAt(events, index) {
    const spans = events.spans.filter(([from, to]) => from <= index && index <= to);
    return spans.map(([, , text]) => events.texts[text]);
  }

  function modeAt(index) {
    let current = "";
    for (const [from, mode] of playback.modes) if (from <= index) current = mode;
    return current;
  }

  function updateReadings() {
    const fixed = (name, digits) => Number.isFinite(data[name][frame]) ? number(data[name][frame], digits) : "–";
    const faults = textsAt(playback.faults, frame);
    const { stops, reductions } = playback.protection;
    const actions = [...textsAt(stops, frame), ...textsAt(reductions, frame)];
    const isLate = data.decision_time[frame] > playback.deadline_ms;
    const texts = {
      time: fixed("time", 2), mode: modeAt(frame), fault: faults.join("; ") || "none",
      protection: actions.join("; ") || "no action", speed: fixed("speed", 2), commanded_speed: fixed("commanded_speed", 2),
      turn_rate: fixed("turn_rate", 2), commanded_turn_rate: fixed("commanded_turn_rate", 2), gap: fixed("gap", 3),
      decision_time: fixed("decision_time", 2) + (isLate ? " LATE" : ""),
      admissible: data.samples[frame] > 0 ? data.admissible[frame] + " of " + data.samples[frame] : "–",
      heading: fixed("heading", 3), clearance: fixed("clearance", 3), velocity: fixed("velocity", 3),
      path: fixed("path", 3), score: fixed("score", 7),
      plan: data.plan[frame] + 1 + " of " + playback.paths.length,
    };
    for (const [name, text] of Object.entries(texts)) readings.get(name).textContent = text;
    readings.get("fault").classList.toggle("is-fault", faults.length > 0);
    for (const button of figure.querySelectorAll(".events [data-frame]")) button.setAttribute("aria-current", Number(button.dataset.frame) === frame);
    slider.value = frame;
    slider.setAttribute("aria-valuetext", [texts.time + " s", texts.mode, ...faults, ...actions].join(", "));
  }

  function show(index) {
    frame = Math.max(0, Math.min(playback.lastFrame, index));
    draw();
  }

  function setPlaying(on) {
    isPlaying = on;
    playButton.textContent = on ? "Pause" : "Play";
    clearTimeout(addressTimer);
    if (!on) {
      addressTimer = setTimeout(() => history.replaceState(null, "", momentFragment(section, data.time[frame])), ADDRESS_DELAY_MS);
      return;
    }
    if (frame === playback.lastFrame) show(0);
    [lastUpdate, pendingTime] = [performance.now(), 0];
    requestAnimationFrame(advance);
  }

  // Advances by the frames of the elapsed time, scaled by the selected speed.
  function advance(now) {
    if (!isPlaying) return;
    pendingTime += (now - lastUpdate) / 1000 * Number(speed.value);
    lastUpdate = now;
    let next = frame;
    while (next < playback.lastFrame && pendingTime >= data.time[next + 1] - data.time[next]) {
      pendingTime -= data.time[next + 1] - data.time[next];
      next++;
    }
    if (next !== frame) show(next);
    if (next === playback.lastFrame) return setPlaying(false);
    requestAnimationFrame(advance);
  }

  function stopAt(index) {
    onSelect();
    setPlaying(false);
    show(index);
  }

  function togglePlaying() {
    onSelect();
    setPlaying(!isPlaying);
  }

  function showLinkedTime() {
    const time = linkedTime(section);
    if (time !== undefined) show(playback.frameAt(time));
    if (location.hash.startsWith("#" + section.id + "&")) figure.scrollIntoView();
  }

  function copyLink(button) {
    const address = find(".moment-link");
    address.textContent = location.href.split("#")[0] + momentFragment(section, data.time[frame]);
    address.hidden = false;
    copyText(button, address);
  }

  const actions = {
    play: togglePlaying, back: () => stopAt(frame - 1), forward: () => stopAt(frame + 1),
    "zoom-in": () => view.zoomBy(1.4), "zoom-out": () => view.zoomBy(1 / 1.4), whole: view.showWhole, reset: view.reset,
    link: () => copyLink(action("link")),
  };
  for (const [name, run] of Object.entries(actions)) action(name).addEventListener("click", run);
  slider.addEventListener("input", () => stopAt(Number(slider.value)));
  figure.addEventListener("click", (event) => {
    const button = event.target.closest(".events [data-frame]");
    if (button) stopAt(Number(button.dataset.frame));
  });
  for (const box of layers.values()) box.addEventListener("change", draw);

  // Pixels by which a key moves the map.
  const pan = 60;
  const keyActions = {
    " ": actions.play, ArrowLeft: actions.back, ArrowRight: actions.forward, Home: () => stopAt(0), End: () => stopAt(playback.lastFrame),
    "+": actions["zoom-in"], "=": actions["zoom-in"], "-": actions["zoom-out"], 0: view.reset, w: view.showWhole,
    f: view.toggleFollow,
  };
  const panActions = {
    ArrowLeft: () => view.panBy(pan, 0), ArrowRight: () => view.panBy(-pan, 0),
    ArrowUp: () => view.panBy(0, pan), ArrowDown: () => view.panBy(0, -pan),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const run = (event.shiftKey && panActions[key]) || keyActions[key];
    if (run) { event.preventDefault(); run(); }
  });
  document.addEventListener("keydown", (event) => {
    const focused = document.activeElement;
    if (event.key === "?" && (focused === document.body || figure.contains(focused))) keyHelp.open = !keyHelp.open;
  });
  window.addEventListener("resize", draw);
  window.addEventListener("hashchange", showLinkedTime);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { colours = readColours(); draw(); });
  show(0);
  showLinkedTime();
  if (location.hash.split("&").includes("play")) setPlaying(true);

  // Adds frames to the playback, and shows a frame.
  function append(part, index) {
    playback.append(part);
    timeline.rescale();
    slider.max = playback.lastFrame;
    show(index ?? frame);
  }

  return { playback, append, show };
}
