// Extent of the map around a followed robot, and of the closest view, along the shorter side of the canvas, metres.
const FOLLOW_EXTENT_M = 6, MIN_EXTENT_M = 0.8;

// Distance in pixels from which on a press moves the map.
const DRAG_PX = 4;

// The part of the drawing that a canvas shows. `robot` returns the robot's position; `onChange` is called after each change.
function createView(canvas, playback, followBox, robot, onChange) {
  const middle = [playback.width / 2, playback.height / 2];
  // The extent is the length along the shorter side of the canvas, in drawing units, so that a view outlasts a new window size.
  let center = middle, extent = FOLLOW_EXTENT_M * playback.scale, follows = followBox.checked;
  const pointers = new Map();

  const shorterSide = () => Math.min(canvas.clientWidth, canvas.clientHeight);
  const wholeExtent = () => shorterSide() / Math.min(canvas.clientWidth / playback.width, canvas.clientHeight / playback.height);
  const limited = (value) => Math.max(MIN_EXTENT_M * playback.scale, Math.min(wholeExtent(), value));
  const zoom = () => shorterSide() / limited(extent);
  const shownCenter = () => follows ? robot() : center;

  function setFollows(on) {
    if (!on) center = shownCenter();
    follows = followBox.checked = on;
  }

  // Changes the extent. The point of the map under a pixel stays there, unless the robot stays in the middle. Returns whether
  // the extent changed.
  function zoomBy(factor, pixel) {
    const before = zoom(), shown = limited(extent);
    extent = limited(shown / factor);
    if (!follows && pixel) {
      const change = 1 / before - 1 / zoom();
      moveTo([center[0] + (pixel[0] - canvas.clientWidth / 2) * change, center[1] + (pixel[1] - canvas.clientHeight / 2) * change]);
    }
    onChange();
    return extent !== shown;
  }

  function moveTo([x, y]) {
    center = [Math.max(0, Math.min(playback.width, x)), Math.max(0, Math.min(playback.height, y))];
  }

  // Moves the map by pixels, and follows the robot no longer.
  function panBy(right, down) {
    setFollows(false);
    moveTo([center[0] - right / zoom(), center[1] - down / zoom()]);
    onChange();
  }

  function showWhole() {
    setFollows(false);
    [center, extent] = [middle, Infinity];
    onChange();
  }

  function reset() {
    extent = FOLLOW_EXTENT_M * playback.scale;
    setFollows(true);
    onChange();
  }

  function follow(on) {
    setFollows(on);
    onChange();
  }

  // The middle of all pressed pointers, and their mean distance from it.
  function pinch() {
    const all = [...pointers.values()];
    const mean = (axis) => all.reduce((sum, pointer) => sum + pointer[axis], 0) / all.length;
    const [x, y] = [mean("x"), mean("y")];
    return { x, y, spread: all.reduce((sum, pointer) => sum + Math.hypot(pointer.x - x, pointer.y - y), 0) / all.length };
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY, isDrag: false });
  });
  canvas.addEventListener("pointermove", (event) => {
    const pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    const { offsetX: x, offsetY: y } = event;
    if (!pointer.isDrag && Math.hypot(x - pointer.x, y - pointer.y) < DRAG_PX) return;
    const before = pinch();
    [pointer.x, pointer.y, pointer.isDrag] = [x, y, true];
    const after = pinch();
    if (pointers.size > 1) zoomBy(after.spread / Math.max(1, before.spread), [after.x, after.y]);
    if (pointers.size === 1 || !follows) panBy(after.x - before.x, after.y - before.y);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  // At the ends of the zoom the wheel scrolls the page.
  canvas.addEventListener("wheel", (event) => {
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : 16);
    if (zoomBy(Math.exp(-pixels * (event.ctrlKey ? 0.01 : 0.0015)), [event.offsetX, event.offsetY])) event.preventDefault();
  }, { passive: false });
  followBox.addEventListener("change", () => follow(followBox.checked));

  return { zoom, center: shownCenter, zoomBy, panBy, showWhole, reset, toggleFollow: () => follow(!follows) };
}
