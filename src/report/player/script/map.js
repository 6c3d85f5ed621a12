// Draws the map with the robot, its lidar returns, the samples and the moving obstacles at a frame.
function createMap(canvas, playback, mapImage, isShown) {
  const { data } = playback;

  // The view decides what is shown, in drawing units; line widths and marks are in pixels.
  function draw(view, frame, colours) {
    const most = window.innerHeight * 0.7, whole = canvas.clientWidth * playback.height / playback.width;
    const { context, width, height } = prepareCanvas(canvas, Math.min(most, Math.max(300, whole)));
    const zoom = view.zoom(), center = view.center(), pixel = 1 / zoom;
    context.fillStyle = colours.page;
    context.fillRect(0, 0, width, height);
    context.save();
    context.translate(width / 2, height / 2);
    context.scale(zoom, zoom);
    context.translate(-center[0], -center[1]);
    drawGrid(context, zoom, colours);
    if (isShown("path")) drawPath(context, pixel, frame, colours);
    drawTargets(context, pixel, frame, colours);
    if (isShown("lidar")) drawLidar(context, pixel, frame, colours);
    if (isShown("predictions")) drawPredicted(context, frame, colours);
    if (isShown("moving")) for (const [x, y, radius] of playback.moving[frame]) drawDisc(context, x, y, radius, colours.moving, 0.55);
    drawSamples(context, pixel, frame, colours);
    if (isShown("track")) drawTrack(context, pixel, frame, colours);
    drawRobot(context, pixel, frame, colours);
    context.restore();
    drawScaleBar(context, width, height, zoom, colours);
  }

  function drawGrid(context, zoom, colours) {
    // The map may continue beyond the drawing, so only the drawing has the colour of the outside.
    context.fillStyle = colours.outside;
    context.fillRect(0, 0, playback.width, playback.height);
    if (!mapImage || !mapImage.picture.complete || !mapImage.picture.naturalWidth) return;
    const { picture, transform } = mapImage;
    context.save();
    context.beginPath();
    context.rect(0, 0, playback.width, playback.height);
    context.clip();
    context.transform(...transform);
    // Cells of a pixel or more have sharp edges; smaller ones are interpolated as in a photograph.
    const cellPixels = Math.hypot(transform[0], transform[1]) * zoom * (window.devicePixelRatio || 1);
    context.imageSmoothingEnabled = cellPixels < 1;
    // Free cells are transparent in the image.
    context.fillStyle = colours.panel;
    context.fillRect(0, 0, picture.naturalWidth, picture.naturalHeight);
    context.globalAlpha = Number(colours["rock-strength"]) || 1;
    context.drawImage(picture, 0, 0);
    context.restore();
  }

  function drawPath(context, pixel, frame, colours) {
    const current = playback.paths[data.plan[frame]];
    if (!current) return;
    context.strokeStyle = colours.path;
    context.lineWidth = 5 * pixel;
    context.globalAlpha = 0.5;
    drawLine(context, current);
    context.globalAlpha = 1;
  }

  // The goal and the key node.
  function drawTargets(context, pixel, frame, colours) {
    const [x, y] = playback.goal;
    context.strokeStyle = colours.ink;
    context.lineWidth = 2 * pixel;
    for (const radius of [8, 3]) {
      context.beginPath();
      context.arc(x, y, radius * pixel, 0, 2 * Math.PI);
      context.stroke();
    }
    drawDisc(context, data.target_x[frame], data.target_y[frame], 5 * pixel, colours.path, 1);
  }

  // The track up to the current frame.
  function drawTrack(context, pixel, frame, colours) {
    context.strokeStyle = colours.robot;
    context.lineWidth = 2 * pixel;
    context.globalAlpha = 0.7;
    context.beginPath();
    for (let index = 0; index <= frame; index++) context.lineTo(data.x[index], data.y[index]);
    context.stroke();
    context.globalAlpha = 1;
  }

  function drawLidar(context, pixel, frame, colours) {
    const { beams } = playback, yaw = data.yaw[frame];
    const ahead = data.lidar_x[frame] * playback.scale, left = data.lidar_y[frame] * playback.scale;
    const x = data.x[frame] + ahead * Math.cos(yaw) - left * Math.sin(yaw);
    const y = data.y[frame] - ahead * Math.sin(yaw) - left * Math.cos(yaw);
    context.fillStyle = colours.bad;
    // About the size of the beam, as far as it stays visible and does not cover the map.
    const dot = Math.max(2 * pixel, Math.min(4 * pixel, 0.06 * playback.scale));
    for (let beam = 0; beam < beams; beam++) {
      const range = playback.ranges[frame * beams + beam];
      if (range >= 254) continue;
      const distance = range / 253 * data.range_max[frame] * playback.scale;
      const angle = yaw + data.angle_min[frame] + beam * data.angle_increment[frame];
      context.fillRect(x + distance * Math.cos(angle) - dot / 2, y - distance * Math.sin(angle) - dot / 2, dot, dot);
    }
  }

  // The predicted positions of moving obstacles over the horizon, fainter with time.
  function drawPredicted(context, frame, colours) {
    for (const [x, y, radius, vx, vy] of playback.predicted[frame]) {
      for (let part = 0; part <= 4; part++) {
        const time = part / 4 * data.horizon[frame];
        drawDisc(context, x + vx * time, y + vy * time, radius, colours.moving, 0.22 - 0.035 * part);
      }
    }
  }

  // The points of a trajectory at constant speed and turn rate.
  function trajectory(frame, v, omega) {
    const points = [], parts = 24;
    const [x, y, yaw] = [data.start_x[frame], data.start_y[frame], data.start_yaw[frame]];
    for (let part = 0; part <= parts; part++) {
      const time = part / parts * data.horizon[frame], half = omega * time / 2;
      const chord = v * time * (Math.abs(half) < 1e-4 ? 1 : Math.sin(half) / half) * playback.scale;
      points.push([x + chord * Math.cos(yaw + half), y - chord * Math.sin(yaw + half)]);
    }
    return points;
  }

  // The samples and, above them, the chosen one.
  function drawSamples(context, pixel, frame, colours) {
    if (Number.isNaN(data.start_x[frame])) return;
    const { trajectories } = playback, columns = data.columns[frame], rows = data.rows[frame];
    const between = (low, high, index, count) => count > 1 ? low + (high - low) * index / (count - 1) : low;
    context.lineWidth = 1.4 * pixel;
    // The best ones are drawn last, above the others.
    const scoreOf = (index) => playback.scores[frame * trajectories + index];
    const order = Array.from({ length: columns * rows }, (_, index) => index);
    order.sort((one, other) => scoreOf(one) - scoreOf(other));
    for (const index of order) {
      const score = scoreOf(index), isRejected = score < 8;
      if (!isShown(isRejected ? "rejected" : "sampled")) continue;
      const v = between(data.v_min[frame], data.v_max[frame], index % columns, columns);
      const omega = between(data.omega_min[frame], data.omega_max[frame], Math.floor(index / columns), rows);
      context.strokeStyle = isRejected ? colours.bad : rampColour(colours, (score - 8) / 247);
      context.globalAlpha = isRejected ? 0.3 : 0.9;
      drawLine(context, playback.sampled[frame][index] ?? trajectory(frame, v, omega));
    }
    context.globalAlpha = 1;
    if (Number.isNaN(data.v[frame]) || !isShown("chosen")) return;
    context.strokeStyle = colours.command;
    context.lineWidth = 3.5 * pixel;
    const chosen = playback.sampled[frame][columns * rows];
    drawLine(context, chosen ?? trajectory(frame, data.v[frame], data.omega[frame]));
  }

  function drawRobot(context, pixel, frame, colours) {
    const [x, y, yaw] = [data.x[frame], data.y[frame], data.yaw[frame]];
    const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)], scale = playback.scale;
    const front = playback.front_m * scale;
    const place = ([ahead, left]) => [x + (ahead * cos - left * sin) * scale, y - (ahead * sin + left * cos) * scale];
    if (playback.body) {
      drawArea(context, playback.body.map(place), colours.robot, 0.6);
    } else {
      for (const disc of playback.discs) drawDisc(context, ...place(disc), disc[2] * scale, colours.robot, 0.6);
    }
    context.strokeStyle = colours.ink;
    context.lineWidth = 2 * pixel;
    drawLine(context, [[x, y], [x + front * cos, y - front * sin]]);
  }

  function drawScaleBar(context, width, height, zoom, colours) {
    const metre = zoom * playback.scale, length = roundNumberAbove(60 / metre);
    const [left, right, y] = [12, 12 + length * metre, height - 12];
    const bar = [[left, y - 4], [left, y + 4], [left, y], [right, y], [right, y - 4], [right, y + 4]];
    for (const [colour, line] of [[colours.panel, 5], [colours.ink, 1.5]]) {
      context.strokeStyle = colour;
      context.lineWidth = line;
      drawLine(context, bar);
    }
    context.font = "12px system-ui, sans-serif";
    drawLabel(context, length + " m", right + 7, y + 4, colours.ink, colours.panel);
  }

  return { draw };
}
