// What the page draws: walkers in lanes, the last seconds of one of them, and its push map.
const FADE = 0.6;                 // s in which a push's arrow fades
const SHOWN = 8;                  // s of the chart
const PER_METRE = 100;            // N s of a push for each metre that is dragged
const GRASP = 0.35;               // m from a place on the body that still take hold of it

/** The lanes of the scene, and where each looks; `share`: of the way from the poses before to those now. */
function lanesOf(canvas, walkers, share) {
  const [pen, wide, high] = prepare(canvas), each = high / walkers.length;
  return walkers.map((walker, i) => ({ walker, ...view(pen, wide, each, i * each, walker.camera * share + walker.looked * (1 - share), walker.page.stature * Math.max(1, walker.size)) }));
}

/** One walker in its lane; `held`: the push that is being drawn. */
function drawLane(lane, share, held) {
  const { pen, wide, high, top, scale, sx, sz, walker } = lane, { figure } = walker.page;
  pen.save();
  pen.beginPath(); pen.rect(0, top, wide, high); pen.clip();
  drawWorld(lane);
  for (const print of walker.prints) drawPrint(lane, print.x, print.leg);
  const pose = walker.pose.map((x, i) => x * share + walker.before[i] * (1 - share));
  const placed = lane.placed = bodies(scaled(figure, walker.size), pose);
  const weight = walker.number("walker.person.ratio.mass") * walker.page.body.weight, leg = walker.page.body.leg * walker.size;
  walker.floats("walker.estimate.touch").forEach((force, side) => {
    const foot = placed[3 + 3 * side], long = force / weight * leg * scale;
    pen.strokeStyle = colours[side ? "near" : "far"]; pen.lineWidth = 2; pen.globalAlpha = 0.7;
    pen.beginPath(); pen.moveTo(sx(foot.x), lane.ground); pen.lineTo(sx(foot.x), lane.ground - long); pen.stroke();
    pen.globalAlpha = 1;
  });
  drawFigure(lane, figure, placed, walker.page.stature, walker.size);
  const capture = sx(walker.capture);
  pen.strokeStyle = colours.ink; pen.lineWidth = 2;
  pen.beginPath(); pen.moveTo(capture - 6, lane.ground - 10); pen.lineTo(capture + 6, lane.ground - 10); pen.lineTo(capture, lane.ground - 1); pen.closePath(); pen.stroke();
  const { last } = walker;
  if (last && !held) {
    const strength = 1 - Math.max(0, walker.time - last.time - walker.page.push) / FADE, on = pushedAt(lane, last);
    if (strength > 0) drawArrow(pen, sx(on.x), sz(on.z), Math.abs(last.impulse) / PER_METRE * scale, last.impulse, strength);
  }
  if (held && held.walker === walker && held.impulse) drawArrow(pen, held.x + held.impulse / PER_METRE * scale, held.y, Math.abs(held.impulse) / PER_METRE * scale, held.impulse);
  font(pen, 14, true); pen.textBaseline = "top"; pen.fillStyle = colours.ink;
  pen.textAlign = "left"; pen.fillText(walker.controller.name, 12, top + 10);
  const slope = walker.number("walker.person.burden.slope") * 180 / Math.PI;
  font(pen, 14);
  if (slope) { pen.textBaseline = "bottom"; pen.textAlign = "right"; pen.fillText(`${number(Math.abs(slope))}° ${slope > 0 ? "uphill" : "downhill"}`, wide - 12, lane.ground - 6); pen.textBaseline = "top"; }
  pen.textAlign = "right"; pen.fillText(`${walker.time.toFixed(2)} s   ${walker.speed.toFixed(2).replace("-", "−")} m/s`, wide - 12, top + 10);
  if (walker.fell) { font(pen, 17, true); pen.fillStyle = colours.push; pen.textAlign = "center"; pen.fillText(`fell: ${walker.fell}`, wide / 2, top + 10); }
  pen.restore();
}

/** The figure of a body `size` times as long: places of the joints, not the shapes. */
function scaled(figure, size) {
  return { bodies: figure.bodies.map((b) => ({ ...b, x: b.x * size, z: b.z * size })) };
}

/** Where a push lands on the body as it is drawn, m. */
function pushedAt({ placed, walker }, { place, height, leg, impulse }) {
  const { imu, depth } = walker.page.figure, { size } = walker;
  if (place === 0) return beside(placed[0], (imu[0] - Math.sign(impulse) * depth) * size, imu[1] * size + height);
  const body = 1 + 3 * leg + (place - 1) % 2, [from, to] = [placed[body], placed[body + 1]];
  return { x: (from.x + to.x) / 2, z: (from.z + to.z) / 2 };
}

/** What of a lane's walker is at a point of the canvas, as a push that has no impulse yet; null: nothing near. */
function grasped(lane, x, y) {
  const { sx, sz, placed, walker } = lane, { imu } = walker.page.figure, { size } = walker;
  const stance = walker.whole("walker.gait.stance"), torso = beside(placed[0], imu[0] * size, imu[1] * size);
  const reach = 0.3 * size, height = clamp((sz(torso.z) - y) / lane.scale / Math.max(0.5, Math.cos(placed[0].turn)), -reach, reach);
  const found = [{ place: 0, height: Math.round(height * 100) / 100, leg: 0, impulse: 0 }];
  for (const leg of [0, 1]) for (const part of [0, 1]) found.push({ place: 1 + part + (leg === stance ? 0 : 2), height: 0, leg, impulse: 0 });
  const near = found.map((one) => { const on = pushedAt(lane, one); return { ...one, x: sx(on.x), y: sz(on.z) }; })
    .reduce((a, b) => (Math.hypot(b.x - x, b.y - y) < Math.hypot(a.x - x, a.y - y) ? b : a));
  return Math.hypot(near.x - x, near.y - y) < Math.max(GRASP * size * lane.scale, 24) ? near : null;
}

const ROWS = [   // widened to what is seen
  { title: "speed, m/s", low: 0, high: 2, lines: [["speed", "speed"]] },
  { title: "torso's pitch, degrees, forward positive", low: -10, high: 20, lines: [["pitch", "ink"]] },
  { title: "force under the feet, body weights", low: 0, high: 2, lines: [["left", "far"], ["right", "near"]] },
  { title: "length of footsteps, m (line: as planned)", low: 0, high: 1, of: "length" },
  { title: "time of footsteps, s (line: as planned)", low: 0, high: 1, of: "seconds" },
];

/** The last seconds of `walker`. */
function drawChart(canvas, walker) {
  const [pen, wide, high] = prepare(canvas), left = 34, right = 6, gap = 24, tall = (high - gap * ROWS.length - 8) / ROWS.length;
  const end = Math.max(walker.time, SHOWN), across = (t) => left + (wide - left - right) * (1 - (end - t) / SHOWN);
  ROWS.forEach((row, i) => {
    const values = row.of ? walker.steps.flatMap((step) => [step[row.of], step.planned[row.of]]) : row.lines.flatMap(([name]) => walker.seen.map((seen) => seen[name]));
    const low = values.reduce((a, b) => Math.min(a, Math.floor(b * 2) / 2), row.low), top = values.reduce((a, b) => Math.max(a, Math.ceil(b * 2) / 2), row.high);
    const from = i * (tall + gap) + gap, up = (v) => from + tall * (1 - (v - low) / (top - low));
    font(pen, 11.5); pen.fillStyle = colours.soft; pen.textAlign = "left"; pen.textBaseline = "bottom"; pen.fillText(row.title, left, from - 6);
    pen.textAlign = "right"; pen.textBaseline = "middle";
    for (const v of new Set([low, 0, top])) {
      pen.fillStyle = v ? colours.line : colours["ground-line"]; pen.fillRect(left, Math.round(up(v)), wide - left - right, 1);
      pen.fillStyle = colours.soft; pen.fillText(number(v), left - 4, up(v));
    }
    pen.save(); pen.beginPath(); pen.rect(left, from - 4, wide - left - right, tall + 8); pen.clip();
    for (const push of walker.pushes) {
      pen.fillStyle = colours.push; pen.globalAlpha = 0.5;
      pen.fillRect(across(push.time), from, Math.max(2, across(push.time + walker.page.push) - across(push.time)), tall);
      pen.globalAlpha = 1;
    }
    for (const [name, colour] of row.lines ?? []) {
      pen.strokeStyle = colours[colour]; pen.lineWidth = 1.6; pen.beginPath();
      for (const seen of walker.seen) pen.lineTo(across(seen.time), up(seen[name]));
      pen.stroke();
    }
    if (row.of) for (const step of walker.steps) {
      const x = across(step.time);
      pen.fillStyle = colours[step.leg ? "near" : "far"];
      pen.beginPath(); pen.arc(x, up(step[row.of]), 3.4, 0, 2 * Math.PI); pen.fill();
      pen.fillStyle = colours.ink; pen.fillRect(x - 6, up(step.planned[row.of]) - 0.75, 12, 1.5);
    }
    pen.restore();
  });
}

/** What a push map knows; the last push of `walker` is ringed where it has a cell. */
function drawMap(canvas, map, walker) {
  const [pen, wide, high] = prepare(canvas), left = 42, foot = 32, w = (wide - left - 4) / PHASES, h = (high - foot - 4) / IMPULSES.length;
  const y = (row) => 4 + (IMPULSES.length - 1 - row) * h;
  font(pen, 11); pen.textBaseline = "middle";
  map.impulses.forEach((impulse, row) => {
    pen.fillStyle = colours.soft; pen.textAlign = "right"; pen.fillText(signed(impulse), left - 5, y(row) + h / 2);
    for (let phase = 0; phase < PHASES; phase++) {
      const known = map.cells?.[row][phase];
      pen.fillStyle = known === undefined ? colours.panel : known ? colours.accent : colours.push;
      pen.globalAlpha = known === undefined ? 1 : 0.85;
      pen.fillRect(left + phase * w + 0.5, y(row) + 0.5, w - 1, h - 1);
      if (known === false) { pen.fillStyle = colours.back; pen.textAlign = "center"; pen.fillText("×", left + (phase + 0.5) * w, y(row) + h / 2); }
      pen.globalAlpha = 1;
    }
  });
  pen.fillStyle = colours.soft; pen.textBaseline = "top"; pen.textAlign = "center";
  for (const phase of [0, 0.25, 0.5, 0.75]) pen.fillText(number(phase), left + (phase * PHASES + 0.5) * w, high - foot + 4);
  pen.fillText("phase of the step in which the push begins;  N s", left + (wide - left) / 2, high - foot + 17);
  const place = walker.last && map.cell(walker.last.phase, walker.last.impulse);
  if (place) {
    pen.strokeStyle = colours.ink; pen.lineWidth = 2.5;
    pen.beginPath(); pen.arc(left + (place[1] + 0.5) * w, y(place[0]) + h / 2, 6, 0, 2 * Math.PI); pen.stroke();
  }
}
