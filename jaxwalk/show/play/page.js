const data = JSON.parse(byId("data").textContent);
const WINDOW = data.window * data.timestep;   // s from one decision to the next
const REST = 4;                               // s after a fall until it starts anew
const scene = byId("scene"), chart = byId("chart"), impulse = byId("impulse");
const machines = {}, settings = { seed: 0 };
let now = null, ahead = [], walkers = [], lanes = [], map = null, held = null;
let playing = false, owed = 0, rested = 0, before = null;

// Walking ------------------------------------------------------------------------------------------
const first = () => walkers[0];

function notice(text) { byId("notice").textContent = text; byId("notice").hidden = !text; }

function say(text, loud = false) {
  const status = byId("status");
  if (status.textContent !== text) status.textContent = text;
  status.classList.toggle("push", loud);
}

/** Everyone who is shown begins, alike. */
function begin(anew = session(settings, shownNames()), seed = settings.seed) {
  anew.settings.seed = settings.seed = seed;
  now = anew; ahead = []; owed = rested = 0;
  walkers = now.shown.map((name) => walkerOf(name));
  for (const walker of walkers) {
    walker.start(now.settings);
    Object.assign(walker, { before: [...walker.pose], looked: walker.pose[0], camera: walker.pose[0], last: null, pushes: [], seen: [] });
  }
  forgetMap();
  scene.className = `lanes-${walkers.length}`;
  byId("watched").textContent = first().controller.name;
}

const kept = {};   // a walker's memory is used again
function walkerOf(name) {
  const controller = data.controllers.find((c) => c.name === name);
  return kept[name] ??= new Walker(machines[controller.module], controller, data);
}

/** Something is done to all who walk, now: it is written down, and happens. */
function act(what) {
  if (what.push && walkers.every((w) => w.done)) return;
  if (now.events.length >= MOST) { say("This session is full: start anew.", true); return; }
  now.events = now.events.filter(([at]) => at <= tick());   // a link's later ones come no more
  ahead = [];
  now.events.push([tick(), what]);
  happens(what);
}

const tick = () => Math.max(...walkers.map((w) => w.tick));

function happens(what) {
  const told = { ...settings };
  for (const walker of walkers) {
    happen(what, walker, told);
    if (!what.push || walker.done) continue;
    const { impulse: size, height = 0, place = 0 } = what.push, side = walker.whole("walker.gait.stance");
    const leg = place === 0 ? null : place <= 2 ? side : 1 - side;
    const body = leg === null ? 0 : 1 + 3 * leg + (place - 1) % 2;
    const above = leg === null ? (data.figure.imu[1] * walker.size + height) : 0;
    walker.last = { impulse: size, time: walker.time, phase: walker.phase, body, above };
    walker.pushes.push(walker.last);
  }
  Object.assign(settings, told); showSettings();
  if (what.push) sayPush(what.push);
}

function sayPush({ impulse: size, height = 0, place = 0 }) {
  const { phase } = first(), on = place ? data.places[place].replace("-", " leg's ") : `torso${height ? `, ${signed(height)} m from its centre` : ""}`;
  const known = place || Math.abs(height) > 0.1 ? undefined : map?.at(phase, size);
  const map_says = known === undefined ? "" : `; its map says: ${known ? "walks on" : "does not walk on"}`;
  say(`Push ${signed(size)} N s at ${phase.toFixed(2)} of the step, on the ${on}${map_says}.`, true);
}

/** All walk one window further. */
function advance() {
  while (ahead.length && ahead[0][0] <= tick()) happens(ahead.shift()[1]);
  for (const walker of walkers) {
    walker.before = [...walker.pose];
    const landed = walker.whole("walker.gait.stance");
    const was = walker.done;
    walker.window();
    const pose = walker.pose;
    walker.looked = walker.camera;
    walker.camera += (pose[0] - walker.camera) * WINDOW / 0.3;
    if (walker.done) {
      if (!was) { walker.fell = walker.reason; if (walker === first()) say(`Fell at ${walker.time.toFixed(2)} s: ${walker.fell}.`, true); }
      continue;
    }
    watch(walker, landed);
  }
  rested = walkers.every((w) => w.done) ? rested + WINDOW : 0;
  if (rested > REST) begin(session(settings, shownNames()), (settings.seed + 1) % 2 ** 32);
}

/** Write down what the chart and the floor show. */
function watch(walker, stance) {
  const { time } = walker, touch = walker.floats("walker.estimate.touch");
  const weight = walker.number("walker.person.ratio.mass") * data.body.weight;
  walker.seen.push({ time, speed: walker.speed, pitch: walker.pose[2] * 180 / Math.PI, left: touch[0] / weight, right: touch[1] / weight });
  if (walker.seen[0].time < time - SHOWN) walker.seen.shift();
  const leg = walker.whole("walker.gait.stance");
  if (leg !== stance) {
    const placed = bodies(scaled(data.figure, walker.size), walker.pose), foot = data.figure.shapes.find((s) => s.kind === "foot" && s.body === 3 + 3 * leg);
    const [toe, heel] = foot.points.slice(1), x = beside(placed[3 + 3 * leg], (toe[0] + heel[0]) / 2 * walker.size, toe[1] * walker.size).x;
    walker.prints.push({ x, leg });
    walker.steps.push({ time, leg, length: walker.number("last.length"), seconds: walker.number("last.seconds") });
    for (const old of [walker.prints, walker.steps]) if (old.length > 30) old.shift();
  }
}

// What is shown ------------------------------------------------------------------------------------
function draw() {
  const share = held ? 1 : Math.min(1, owed / WINDOW);
  lanes = lanesOf(scene, walkers, share);
  for (const lane of lanes) drawLane(lane, share, held);
  drawChart(chart, first());
  drawMap(byId("map"), map, first());
  Object.assign(scene.dataset, { tick: tick(), fell: first().fell ?? "", playing });
}

function frame(at) {
  const passed = before === null ? 0 : Math.min(at - before, 100) / 1000;
  before = at;
  if (playing && !held) {
    owed += passed * Number(byId("rate").value);
    while (owed >= WINDOW) { advance(); owed -= WINDOW; }
  }
  if (map?.work) { const more = map.slice(8); showMap(more); }
  draw();
  requestAnimationFrame(frame);
}

function play(on) {
  playing = on;
  byId("play").classList.toggle("playing", on);
  byId("play-word").textContent = on ? "Pause" : "Play";
}

function again() { begin(session(settings, shownNames()), (settings.seed + 1) % 2 ** 32); say("Walking."); }

// The push map -------------------------------------------------------------------------------------
function forgetMap() { if (map) { map.cells = null; map.work = null; } byId("measure").disabled = false; byId("measured").textContent = "One push a cell, on the torso's centre: does it walk on?"; }

function measure() {
  const { controller } = first();
  if (map?.walker.controller !== controller) map = new PushMap(machines[controller.module], controller, data);
  map.begin(settings);
  byId("measure").disabled = true;
}

function showMap(more) {
  byId("measured").textContent = more ? `${Math.round(100 * map.share)} % measured` : `${map.cells.flat().filter(Boolean).length} of ${map.cells.flat().length} pushes: it walks on. ${Math.round(map.rate / 1000)},000 ticks a second.`;
  byId("measure").disabled = more;
}

// Controls -----------------------------------------------------------------------------------------
function shownNames() { return [...byId("shown").querySelectorAll("input:checked")].map((x) => x.value); }

function chips() {
  for (const { name, what } of data.controllers) {
    const label = document.createElement("label"), input = document.createElement("input"), text = document.createElement("span"), small = document.createElement("small");
    label.className = "walk"; small.textContent = what;
    Object.assign(input, { type: "checkbox", value: name, checked: name === data.controllers[0].name });
    input.addEventListener("change", () => { if (!shownNames().length) input.checked = true; begin(); });
    text.append(name, small); label.append(input, text); byId("shown").append(label);
  }
}

const sliders = {};
function makeSliders() {
  for (const [name, { label, unit, low, high, step, value, times = 1 }] of Object.entries(data.sliders)) {
    settings[name] = value;
    const row = document.createElement("label"), text = document.createElement("span"), shown = document.createElement("output"), input = document.createElement("input");
    Object.assign(input, { type: "range", min: low * times, max: high * times, step: step * times, value: value * times });
    text.textContent = label; row.append(text, shown, input); byId("sliders").append(row);
    sliders[name] = { input, shown, unit, times };
    input.addEventListener("input", () => change(name, Number(input.value) / times));
  }
  showSettings();
}

function change(name, value) {
  if (data.sliders[name].fixed) { settings[name] = value; begin(); } else act({ [name]: value });
  forgetMap();
  showSettings();
}

function showSettings() {
  for (const [name, { input, shown, unit, times }] of Object.entries(sliders)) {
    input.value = settings[name] * times;
    shown.textContent = `${number(settings[name] * times)} ${unit}`;
  }
}

function shove(sign) { act({ push: { impulse: sign * Number(impulse.value) } }); }
function showSize() { byId("size").textContent = `${impulse.value} N s`; }

// Dragging: time stands still, and the arrow is the push.
const place = (event) => { const box = scene.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
scene.addEventListener("pointerdown", (event) => {
  const [x, y] = place(event), lane = lanes.find((l) => y >= l.top && y < l.top + l.high);
  if (!lane || lane.walker.done) return;
  held = { ...grasped(lane, x, y), walker: lane.walker, from: x, scale: lane.scale, impulse: 0 };
  scene.setPointerCapture(event.pointerId); scene.classList.add("held");
});
scene.addEventListener("pointermove", (event) => {
  if (!held) return;
  held.impulse = clamp(Math.round((place(event)[0] - held.from) / held.scale * PER_METRE), -data.most, data.most);
});
scene.addEventListener("pointerup", () => {
  const told = held; letGo();
  if (told?.impulse) act({ push: { impulse: told.impulse, height: +(told.height / told.walker.size).toFixed(3) * told.walker.size, place: told.place } });
});
scene.addEventListener("pointercancel", () => letGo());
function letGo() { held = null; scene.classList.remove("held"); }

byId("play").addEventListener("click", () => play(!playing));
byId("frame").addEventListener("click", () => { play(false); advance(); });
byId("again").addEventListener("click", again);
byId("back").addEventListener("click", () => shove(-1));
byId("ahead").addEventListener("click", () => shove(1));
byId("measure").addEventListener("click", measure);
impulse.addEventListener("input", showSize);
byId("link").addEventListener("click", async () => {
  history.replaceState(null, "", `#${linkOf(now, tick())}`);
  try { await navigator.clipboard.writeText(location.href); say("The link is copied; it is this page's address now."); } catch { say("The link is this page's address now."); }
});
byId("save").addEventListener("click", () => {
  const link = document.createElement("a"), text = JSON.stringify(told(now, tick()), null, 1);
  link.href = `data:application/json,${encodeURIComponent(text)}`; link.download = "push.json"; link.click();
  say(`Saved as push.json: jaxwalk render ${data.policy.name} --session push.json --out push.mp4`);
});

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select, summary, input[type=range]")) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (event.target.matches("button, input") && key === " ") return;
  const size = (by) => { impulse.value = Number(impulse.value) + by; showSize(); };
  const does = {
    ArrowRight: () => shove(1), ArrowLeft: () => shove(-1), ArrowUp: () => size(10), ArrowDown: () => size(-10),
    " ": () => play(!playing), ".": () => { play(false); advance(); }, r: again, m: measure,
  }[key];
  if (does) { does(); event.preventDefault(); }
});

// Beginning ----------------------------------------------------------------------------------------
/** Walk what a link tells of, up to a second before what was done last. */
function follow(found) {
  Object.assign(settings, found.settings);
  for (const input of byId("shown").querySelectorAll("input")) input.checked = found.shown.includes(input.value);
  const replayed = session(found.settings, found.shown);
  begin(replayed, found.settings.seed);
  replayed.events = [...found.events]; ahead = [...found.events];
  const last = found.events.length ? found.events[found.events.length - 1][0] : found.ticks;
  while (!first().done && first().time < last * data.timestep - 1) advance();
  showSettings(); say("As the link tells.");
}

function opened() {
  notice("");
  const text = location.hash.slice(1);
  if (!text) return false;
  try { follow(ofLink(text)); return true; } catch (error) { notice(`${error.message}; this walker starts anew.`); return false; }
}

async function main() {
  if (typeof WebAssembly !== "object") { notice("This browser has no WebAssembly, by which the walker is simulated: take one of 2017 or later."); return; }
  for (const [name, module] of Object.entries(data.modules)) machines[name] = await machine(module);
  chips(); makeSliders(); showSize(); begin();
  opened();
  addEventListener("hashchange", () => { if (!opened()) begin(); });
  themed(() => { if (walkers.length) draw(); });
  play(true);
  requestAnimationFrame(frame);
  globalThis.jaxwalk = { data, machines, Walker, PushMap, walkers: () => walkers, session: () => told(now, tick()) };  // for whoever scripts the page
}
main().catch((error) => notice(`The walker cannot be simulated here: ${error.message}`));
