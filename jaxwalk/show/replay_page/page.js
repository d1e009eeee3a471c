const data = JSON.parse(document.getElementById("data").textContent);
const { figure, walks } = data;
const UNIT = 1e-3;                 // of the whole numbers
const FADE = 0.6;                  // s, in which a push's arrow fades after it
const RATES = [0.1, 0.25, 0.5, 1, 2];
const COLUMNS = ["x", "z", "pitch", "hip_left", "knee_left", "ankle_left", "hip_right", "knee_right", "ankle_right"];
const scene = byId("scene"), chart = byId("chart"), scrub = byId("scrub"), rate = byId("rate");
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
let chosen = Math.min(1, walks.length - 1), time = 0, playing = false, drawnAt = null, plot = null;

const walk = () => walks[chosen];
const lasts = (w) => (w.columns.x.length - 1) * w.step;

// Poses ------------------------------------------------------------------------------------------
/** A column's value at a time, between its poses on a straight line. */
function at(column, w, t) {
  const place = clamp(t / w.step, 0, column.length - 1);
  const i = Math.min(Math.floor(place), column.length - 2), share = place - i;
  if (i < 0) return column[0] * UNIT;
  return (column[i] * (1 - share) + column[i + 1] * share) * UNIT;
}

const placed = (w, t) => bodies(figure, COLUMNS.map((name) => at(w.columns[name], w, t)));

/** Where each footfall of a walk put its foot, m. */
function prints(w) {
  w.prints ??= w.footfalls.map(([ms, leg]) => {
    const foot = figure.shapes.find((s) => s.kind === "foot" && s.colour === (leg ? "near" : "far"));
    const [toe, heel] = foot.points.slice(1);
    return { time: ms * UNIT, leg, x: beside(placed(w, ms * UNIT)[foot.body], (toe[0] + heel[0]) / 2, toe[1]).x };
  });
  return w.prints;
}

// The scene --------------------------------------------------------------------------------------
function drawScene() {
  const w = walk(), [pen, wide, high] = prepare(scene);
  const seen = view(pen, wide, high, 0, at(w.camera, w, time), data.stature);
  // What the canvas shows, for whoever wants to measure in it.
  Object.assign(scene.dataset, { time: time.toFixed(4), left: seen.left.toFixed(5), scale: seen.scale.toFixed(4), ground: seen.ground.toFixed(3) });
  drawWorld(seen);
  for (const print of prints(w)) {
    if (print.time > time) break;
    drawPrint(seen, print.x, print.leg);
  }
  const now = placed(w, time);
  drawFigure(seen, figure, now, data.stature);
  drawPush(seen, w, now[0]);

  const size = wide < 500 ? 14 : 16, margin = 12;
  font(pen, size); pen.fillStyle = colours.ink; pen.textBaseline = "top";
  pen.textAlign = "left"; pen.fillText(`${time.toFixed(2)} s`, margin, margin);
  pen.textAlign = "right"; pen.fillText(`${at(w.columns.x, w, time).toFixed(1).replace("-", "−")} m`, wide - margin, margin);
  if (w.fell !== null && time >= w.fell) {
    font(pen, size * 1.25, true); pen.fillStyle = colours.push; pen.textAlign = "center"; pen.fillText("fell", wide / 2, margin);
  }
  drawnAt = time;
}

function drawPush({ pen, scale, sx, sz }, w, torso) {
  if (!w.push || time < w.push.start) return;
  const { impulse, start, end, height } = w.push;
  // Where it happened stays marked on the floor.
  w.pushedAt ??= at(w.columns.x, w, start);
  pen.fillStyle = colours.push;
  pen.fillRect(sx(w.pushedAt) - 1.5, sz(0), 3, 12);
  const strength = time <= end ? 1 : 1 - (time - end) / FADE;
  if (strength <= 0) return;
  const on = beside(torso, figure.imu[0] - Math.sign(impulse) * figure.depth, figure.imu[1] + height);
  const long = data.stature * Math.min(0.12 + 0.0035 * Math.abs(impulse), 0.45) * scale;
  drawArrow(pen, sx(on.x), sz(on.z), long, impulse, strength);
}

// The chart --------------------------------------------------------------------------------------
const ROWS = [
  { title: "torso speed, m/s", share: 0.4, of: (w) => w.speed.map((v) => v * UNIT) },
  { title: "step length, m", share: 0.3, of: (w) => w.footfalls.map((f) => f[2] * UNIT) },
  { title: "step duration, s", share: 0.3, of: (w) => w.footfalls.map((f) => f[3] * UNIT) },
];
for (const row of ROWS) {  // one scale for all walks, so that they can be compared
  const values = walks.flatMap(row.of).concat(0);
  row.low = values.reduce((a, b) => Math.min(a, b)); row.high = values.reduce((a, b) => Math.max(a, b), 0.1);
}

/** A round distance between the lines of a scale. */
function spacing(range, most) {
  const rough = range / most, power = 10 ** Math.floor(Math.log10(rough));
  return power * [1, 2, 5, 10].find((n) => n * power >= rough);
}

function drawChart() {
  const w = walk(), [pen, wide, high] = prepare(chart);
  const left = 38, right = 8, foot = 20, gap = 20, room = high - foot - gap * ROWS.length;
  const across = (t) => left + (wide - left - right) * (t / data.longest);
  plot = { left, width: wide - left - right };
  let top = 0;
  font(pen, 11.5);
  const lines = [];
  for (const row of ROWS) {
    const from = top + gap, tall = room * row.share, up = (v) => from + tall * (1 - (v - row.low) / (row.high - row.low));
    lines.push({ ...row, from, up });
    pen.textAlign = "left"; pen.textBaseline = "bottom"; pen.fillStyle = colours.soft; pen.fillText(row.title, left + 4, from - 4);
    const each = spacing(row.high - row.low, tall / 13);
    pen.textAlign = "right"; pen.textBaseline = "middle";
    for (let n = Math.ceil(row.low / each); n * each <= row.high + 1e-9; n++) {
      const v = n * each;
      pen.fillStyle = n === 0 ? colours["ground-line"] : colours.line; pen.fillRect(left, Math.round(up(v)), wide - left - right, 1);
      pen.fillStyle = colours.soft; pen.fillText(number(v), left - 6, up(v));
    }
    top = from + tall;
  }
  const bottom = high - foot;
  pen.textAlign = "center"; pen.textBaseline = "top"; pen.fillStyle = colours.soft;
  const each = spacing(data.longest, wide < 500 ? 5 : 10);
  for (let n = 0; n * each <= data.longest + 1e-9; n++) {
    const last = (n + 1) * each > data.longest + 1e-9;
    pen.textAlign = n && last ? "right" : "center";
    pen.fillText(`${number(n * each)}${last ? " s" : ""}`, across(n * each) + (n && last ? right : 0), bottom + 5);
  }
  if (w.push) {
    const { start, end } = w.push;
    pen.fillStyle = colours.push; pen.globalAlpha = 0.85;
    pen.fillRect(across(start), gap, Math.max(2, across(end) - across(start)), bottom - gap);
    pen.globalAlpha = 1;
  }
  if (w.fell !== null) {
    pen.fillStyle = colours.push; pen.textAlign = "left"; pen.textBaseline = "bottom"; pen.fillText("fell", across(w.fell) + 4, gap + 14);
    pen.setLineDash([4, 3]); pen.strokeStyle = colours.push; pen.lineWidth = 1;
    pen.beginPath(); pen.moveTo(across(w.fell), gap); pen.lineTo(across(w.fell), bottom); pen.stroke(); pen.setLineDash([]);
  }
  if (w !== walks[0]) line(pen, walks[0], lines[0], across, colours.ghost, 1.25);
  line(pen, w, lines[0], across, colours.speed, 2);
  for (const row of lines.slice(1)) {
    const values = row.of(w);
    w.footfalls.forEach(([ms, leg], i) => {
      const x = across(ms * UNIT), y = row.up(values[i]);
      pen.fillStyle = pen.strokeStyle = colours[leg ? "near" : "far"];
      pen.lineWidth = 1.5; pen.beginPath(); pen.moveTo(x, row.up(0)); pen.lineTo(x, y); pen.stroke();
      pen.beginPath(); pen.arc(x, y, 3.2, 0, 2 * Math.PI); pen.fill();
    });
  }
  drawCursor(pen, w, lines, across, wide, right, gap, bottom);
}

function line(pen, w, row, across, colour, width) {
  pen.strokeStyle = colour; pen.lineWidth = width; pen.beginPath();
  w.speed.forEach((v, i) => pen.lineTo(across(i * w.step), row.up(v * UNIT)));
  pen.stroke();
}

/** The moment that is shown, with its numbers at the right of each row's title. */
function drawCursor(pen, w, lines, across, wide, right, gap, bottom) {
  const x = across(time);
  pen.fillStyle = colours.ink; pen.fillRect(x - 0.75, gap - 4, 1.5, bottom - gap + 4);
  const walked = w.footfalls.filter((f) => f[0] * UNIT <= time), step = walked[walked.length - 1];
  const up = time / w.step <= w.speed.length - 1;
  const shown = [up ? at(w.speed, w, time) : null, step ? step[2] * UNIT : null, step ? step[3] * UNIT : null];
  font(pen, 12.5, true); pen.textAlign = "right"; pen.textBaseline = "bottom";
  lines.forEach((row, i) => {
    if (shown[i] !== null) pen.fillText(shown[i].toFixed(2).replace("-", "−"), wide - right, row.from - 3);
  });
}

// What is going on -------------------------------------------------------------------------------
function said() {
  const w = walk();
  if (w.fell !== null && time >= w.fell) return [`fell at ${w.fell.toFixed(2)} s`, true];
  if (w.push && time >= w.push.start && time <= w.push.end + FADE) return [`push ${signed(w.push.impulse)} N s`, true];
  if (w.push && time > w.push.end) return [`pushed at ${w.push.start.toFixed(2)} s`, false];
  return ["walking", false];
}

function show() {
  if (!plot || drawnAt !== time) { drawScene(); drawChart(); }
  const w = walk(), [text, loud] = said(), status = byId("status");
  scrub.value = time;
  scrub.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
  byId("clock").textContent = `${time.toFixed(2)} / ${lasts(w).toFixed(2)} s`;
  if (status.textContent !== text) status.textContent = text;
  status.classList.toggle("push", loud);
}

function redraw() { plot = null; show(); }

// Time -------------------------------------------------------------------------------------------
function seek(t) { time = clamp(t, 0, lasts(walk())); show(); }

function play(on) {
  if (on && time >= lasts(walk()) - 1e-9) time = 0;
  const began = on && !playing;
  playing = on;
  byId("play").classList.toggle("playing", on);
  byId("play-word").textContent = on ? "Pause" : "Play";
  if (began) { let before = null; requestAnimationFrame(function frame(now) {
    if (!playing) return;
    const passed = before === null ? 0 : Math.min(now - before, 100) / 1000;
    before = now;
    seek(time + passed * Number(rate.value));
    if (time >= lasts(walk()) - 1e-9) play(false); else requestAnimationFrame(frame);
  }); }
  show();
}

function choose(i) {
  if (i < 0 || i >= walks.length) return;
  chosen = i;
  byId("walks").querySelectorAll("input")[i].checked = true;
  scrub.max = lasts(walk());
  scene.setAttribute("aria-label", `The walker from its right side; ${told(walk()).join(", ")}`);
  time = clamp(time, 0, lasts(walk()));
  redraw();
}

function told(w) {
  const from = !w.push ? "unpushed" : `${signed(w.push.impulse)} N s, pushed ${w.push.impulse < 0 ? "from the front" : "from behind"}`;
  return [from, w.fell === null ? "kept walking" : `fell at ${w.fell.toFixed(1)} s`];
}

// Controls ---------------------------------------------------------------------------------------
walks.forEach((w, i) => {
  const label = document.createElement("label"), input = document.createElement("input");
  const text = document.createElement("span"), from = document.createElement("small"), end = document.createElement("small");
  label.className = "walk";
  Object.assign(input, { type: "radio", name: "walk", value: i });
  input.addEventListener("change", () => choose(i));
  text.append(w.push ? `${signed(w.push.impulse)} N s` : "No push");
  from.textContent = !w.push ? "same start" : w.push.impulse < 0 ? "from the front" : "from behind";
  end.textContent = told(w)[1]; end.className = w.fell === null ? "" : "fell";
  text.append(from, end); label.append(input, text); byId("walks").append(label);
});
byId("play").addEventListener("click", () => play(!playing));
scrub.addEventListener("input", () => { const wanted = Number(scrub.value); play(false); seek(wanted); });
rate.addEventListener("change", show);

const pointed = (event) => {
  const x = event.clientX - chart.getBoundingClientRect().left;
  seek((x - plot.left) / plot.width * data.longest);
};
chart.addEventListener("pointerdown", (event) => { chart.setPointerCapture(event.pointerId); play(false); pointed(event); });
chart.addEventListener("pointermove", (event) => { if (event.buttons) pointed(event); });

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const on = event.target, key = event.key, jump = event.shiftKey ? 1 : 0.1;
  if (on.matches("select, summary") || (on.matches("button") && key === " ")) return;
  if (on.matches('input[type="radio"]') && key.startsWith("Arrow")) return;
  const step = (by) => { play(false); seek(time + by); };
  const faster = (by) => { rate.value = RATES[clamp(RATES.indexOf(Number(rate.value)) + by, 0, RATES.length - 1)]; };
  const does = {
    " ": () => play(!playing), ArrowLeft: () => step(-jump), ArrowRight: () => step(jump),
    ",": () => step(-walk().step), ".": () => step(walk().step),
    ArrowUp: () => faster(1), ArrowDown: () => faster(-1),
    Home: () => seek(0), End: () => seek(lasts(walk())),
    p: () => { if (walk().push) seek(walk().push.start - 0.2); },
  }[key.length === 1 ? key.toLowerCase() : key];
  if (does) does(); else if (/^[1-9]$/.test(key)) choose(Number(key) - 1); else return;
  event.preventDefault();
});

new ResizeObserver(redraw).observe(scene);
data.longest = Math.max(...walks.map(lasts));
themed(redraw);
choose(chosen);
if (!calm) play(true);
