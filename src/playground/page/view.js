// The visible part of the map: converts between metres and pixels.

// Limits of the scale, pixels per metre.
const [MIN_SCALE, MAX_SCALE] = [0.5, 400];

export class View {
  constructor() {
    Object.assign(this, { x: 0, y: 0, scale: 40, width: 1, height: 1, isFitted: true });
  }

  toScreen([x, y]) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld([left, top]) {
    return [this.x + (left - this.width / 2) / this.scale, this.y - (top - this.height / 2) / this.scale];
  }

  // Shows all points with a margin, metres.
  fit(points, margin) {
    const range = (axis) => {
      const values = points.map((point) => point[axis]);
      return [Math.min(...values) - margin, Math.max(...values) + margin];
    };
    const [[left, right], [low, high]] = [range(0), range(1)];
    [this.x, this.y] = [(left + right) / 2, (low + high) / 2];
    this.setScale(Math.min(this.width / (right - left), this.height / (high - low)));
    this.isFitted = true;
  }

  setScale(scale) {
    this.scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale));
    this.isFitted = false;
  }

  // Moves the view so that a point is inside its edge.
  keep(point) {
    const edge = 24, [left, top] = this.toScreen(point);
    const beyond = (place, size) => place < edge ? place - edge : place > size - edge ? place - size + edge : 0;
    this.x += beyond(left, this.width) / this.scale;
    this.y -= beyond(top, this.height) / this.scale;
  }
}
