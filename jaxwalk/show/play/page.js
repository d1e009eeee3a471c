const data = JSON.parse(byId("data").textContent);
const WINDOW = data.window * data.timestep;   // s from one decision to the next
const REST = 4;                               // s after a fall until it starts anew
const SLICE = 10;                             // ms of a frame in which a link is walked again, or a map is measured
const scene = byId("scene"), chart = byId("chart"), impulse = byId("impulse");
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
const machines = {}, settings = { seed: 0 };
const kept = new Map(), maps = new Map();     // of each controller: memory is used again
let now = null, lost = null, ahead = [], chased = 0, walkers = [], lanes = [], held = null;
let playing = false, owed = 0, rested = 0, before = null, stale = true;

// Walking ------------------------------------------------------------------------------------------
const first = () => walkers[0];
const standing = () => walkers.find((w) => !w.done);
const tick = () => Math.max(...walkers.map((w) => w.tick));

function notice(text) { byId("notice").textContent = text; byId("notice").hidden = !text; }

function say(text, loud = false) {
  const status = byId("status");
  if (status.textContent !== text) status.textContent = text;
  status.classList.toggle("push", loud);
}

function mapOf(controller) {
  if (!maps.has(controller)) maps.set(controller, new PushMap(machines[controller.module], controller, data));
  return maps.get(controller);
}
const map = () => mapOf(first().controller);

/** Everyone who is shown begins, alike. */
function begin(anew = session(settings, shownNames()), seed = settings.seed) {
  letGo();
  if (now?.events.length) lost = written(now, tick());
  anew.settings.seed = settings.seed = seed;
  now = anew; ahead = []; chased = owed = rested = 0;
  walkers = now.shown.map((name) => {
    const controller = data.controllers.find((c) => c.name === name);
    if (!kept.has(controller)) kept.set(controller, new Walker(machines[controller.module], controller, data));
    return kept.get(controller);
  });
  for (const walker of walkers) {
    walker.start(now.settings);
    Object.assign(walker, { before: [...walker.pose], looked: walker.pose[0], camera: walker.pose[0] });
  }
  forgetMap();
  scene.className = `lanes-${walkers.length}`;
  byId("watched").textContent = first().controller.name;
  scene.setAttribute("aria-label", `From the right side: ${now.shown.join(", ")}; drag on a body to push it`);
  say("Walking: drag on the body to push it.");
}

/** Something is done to all who walk, now: it is written down, and happens. */
function act(what) {
  while (ahead.length && ahead[0][0] <= tick()) happens(ahead.shift()[1]);
  now.events = now.events.filter(([at]) => at <= tick());   // a link's later ones come no more
  ahead = []; chased = 0;
  if (!standing()) { const { push, ...changed } = what; Object.assign(settings, changed); return; }
  if (what.push && walkers.some((w) => !w.done && w.pushed)) { say("A push still acts: one at a time.", true); return; }
  const last = now.events[now.events.length - 1];
  if (!what.push && last && last[0] === tick() && !last[1].push) Object.assign(last[1], what);
  else if (now.events.length < MOST) now.events.push([tick(), what]);
  else { say("This session is full: start anew.", true); return; }
  happens(what);
}

function happens(what) {
  const after = { ...settings };
  for (const walker of walkers) {
    happen(what, walker, after);
    if (!what.push || walker.done) continue;
    const { impulse: size, height, place } = what.push, side = walker.whole("walker.gait.stance");
    walker.last = { impulse: size, height, place, leg: place <= 2 ? side : 1 - side, time: walker.time, phase: walker.phase };
    walker.pushes.push(walker.last);
    if (walker.pushes.length > 50) walker.pushes.shift();
  }
  Object.assign(settings, after);
  showSettings();
  if (what.push) sayPush(what.push); else forgetMap();
}

function sayPush({ impulse: size, height, place }) {
  const walker = standing(), { phase } = walker ?? first();
  const on = place ? data.places[place].replace("-", " leg's ") : `torso${height ? `, ${signed(height)} m from its centre` : ""}`;
  const when = phase === null ? "" : ` at ${phase.toFixed(2)} of the step`;
  const alone = walker?.pushes.filter((push) => push.time > walker.time - SETTLE).length === 1;
  const known = place || Math.abs(height) > 0.1 || !alone ? undefined : mapOf(walker.controller).at(phase, size);
  const mapped = known === undefined ? "" : `; its map says: ${known ? "walks on" : "does not walk on"}`;
  say(`Push ${signed(size)} N s${when}, on the ${on}${walkers.length > 1 && walker ? ` (${walker.controller.name})` : ""}${mapped}.`, true);
}

/** All walk one window further. */
function advance() {
  while (ahead.length && ahead[0][0] <= tick()) happens(ahead.shift()[1]);
  for (const walker of walkers) {
    const { done } = walker, stance = walker.whole("walker.gait.stance");
    const planned = { length: walker.number("walker.gait.length"), seconds: walker.number("walker.gait.duration") };
    walker.before = [...walker.pose];
    walker.window();
    walker.looked = walker.camera;
    walker.camera += (walker.pose[0] - walker.camera) * WINDOW / 0.3;
    if (!walker.done) watch(walker, stance, planned);
    else if (!done) { walker.fell = walker.reason; say(`${walkers.length > 1 ? `${walker.controller.name} fell` : "Fell"} at ${walker.time.toFixed(2)} s: ${walker.fell}.`, true); }
  }
  rested = standing() ? 0 : rested + WINDOW;
  if (rested > REST) again();
}

/** Write down what the chart and the floor show. */
function watch(walker, stance, planned) {
  const { time } = walker, touch = walker.floats("walker.estimate.touch");
  const weight = walker.number("walker.person.ratio.mass") * data.body.weight;
  walker.seen.push({ time, speed: walker.speed, pitch: walker.pose[2] * 180 / Math.PI, left: Math.max(0, touch[0]) / weight, right: Math.max(0, touch[1]) / weight });
  if (walker.seen[0].time < time - SHOWN) walker.seen.shift();
  const leg = walker.whole("walker.gait.stance");
  if (leg === stance) return;
  const placed = bodies(scaled(data.figure, walker.size), walker.pose), foot = data.figure.shapes.find((s) => s.kind === "foot" && s.body === 3 + 3 * leg);
  const [toe, heel] = foot.points.slice(1), x = beside(placed[foot.body], (toe[0] + heel[0]) / 2 * walker.size, toe[1] * walker.size).x;
  walker.prints.push({ x, leg });
  walker.steps.push({ time, leg, planned, length: walker.number("last.length"), seconds: walker.number("last.seconds") });
  for (const old of [walker.prints, walker.steps]) if (old.length > 30) old.shift();
}

function again() { begin(session(settings, shownNames()), (settings.seed + 1) % 2 ** 32); }

// What is shown ------------------------------------------------------------------------------------
function draw() {
  const share = Math.min(1, owed / WINDOW);
  lanes = lanesOf(scene, walkers, share);
  for (const lane of lanes) drawLane(lane, share, held);
  drawChart(chart, first());
  drawMap(byId("map"), map(), first());
  Object.assign(scene.dataset, { tick: tick(), fell: first().fell ?? "", playing });
  stale = false;
}

function frame(at) {
  requestAnimationFrame(frame);
  try {
    const passed = before === null ? 0 : Math.min(at - before, 100) / 1000;
    before = at;
    if (tick() < chased) chase();
    else if (playing && !held) {
      owed += passed * Number(byId("rate").value);
      while (owed >= WINDOW) { advance(); owed -= WINDOW; }
      stale = true;
    }
    if (map().work) { showMap(map().slice(SLICE)); stale = true; }
    if (stale || held) draw();
  } catch (error) { play(false); notice(`This walk cannot go on (${error.message}): start anew.`); }
}

function play(on) {
  playing = on;
  byId("play").classList.toggle("playing", on);
  byId("play-word").textContent = on ? "Pause" : "Play";
}

// The push map -------------------------------------------------------------------------------------
function forgetMap() {
  for (const one of maps.values()) one.forget();
  byId("measure").disabled = false;
  byId("measured").textContent = "One push a cell, on the torso's centre, in steady walking: does it walk on?";
}

function measure() {
  map().begin(settings);
  byId("measure").disabled = true;
}

function showMap(more) {
  const cells = map().cells.flat();
  byId("measured").textContent = more ? `${Math.round(100 * map().share)} % measured` : `${cells.filter(Boolean).length} of ${cells.length} pushes: it walks on. ${Math.round(map().rate / 1000)},000 ticks a second.`;
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
  if (value === settings[name]) return;
  if (data.sliders[name].fixed) { settings[name] = value; begin(); } else act({ [name]: value });
  showSettings();
}

function showSettings() {
  for (const [name, { input, shown, unit, times }] of Object.entries(sliders)) {
    input.value = settings[name] * times;
    shown.textContent = `${number(settings[name] * times)} ${unit}`;
  }
}

function shove(sign) { act({ push: { impulse: sign * Number(impulse.value), height: 0, place: 0 } }); }
function showSize() { byId("size").textContent = `${impulse.value} N s`; }

// Dragging: time stands still, and the arrow is the push.
const pointed = (event) => { const box = scene.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
scene.addEventListener("pointerdown", (event) => {
  const [x, y] = pointed(event), lane = lanes.find((l) => y >= l.top && y < l.top + l.high);
  if (held || !event.isPrimary || event.button || !lane || lane.walker.done) return;
  const near = grasped(lane, x, y);
  if (!near) return;
  held = { ...near, walker: lane.walker, from: x, scale: lane.scale, pointer: event.pointerId };
  scene.setPointerCapture(event.pointerId); scene.classList.add("held");
});
scene.addEventListener("pointermove", (event) => {
  if (event.pointerId !== held?.pointer) return;
  held.impulse = clamp(Math.round((pointed(event)[0] - held.from) / held.scale * PER_METRE), -data.most, data.most);
});
scene.addEventListener("pointerup", (event) => {
  if (event.pointerId !== held?.pointer) return;
  const { impulse: size, height, place } = held;
  letGo();
  if (size) act({ push: { impulse: size, height, place } });
});
scene.addEventListener("pointercancel", () => letGo());
function letGo() { held = null; scene.classList.remove("held"); stale = true; }

byId("play").addEventListener("click", () => play(!playing));
byId("frame").addEventListener("click", () => { play(false); advance(); });
byId("again").addEventListener("click", again);
byId("back").addEventListener("click", () => shove(-1));
byId("ahead").addEventListener("click", () => shove(1));
byId("measure").addEventListener("click", measure);
impulse.addEventListener("input", showSize);

/** This session, or, as long as nothing has been done in it, the one that ended before; null, said, if it cannot be kept. */
function keepable() {
  const found = now.events.length || !lost ? written(now, tick()) : lost;
  try { checked(found); return found; } catch (error) { say(`This session cannot be kept: ${error.message}.`, true); return null; }
}
byId("link").addEventListener("click", async () => {
  const found = keepable();
  if (!found) return;
  history.replaceState(null, "", `#${linkOf(found)}`);
  try { await navigator.clipboard.writeText(location.href); say("The link is copied; it is this page's address now."); } catch { say("The link is this page's address now."); }
});
byId("save").addEventListener("click", () => {
  const found = keepable();
  if (!found) return;
  const link = document.createElement("a");
  link.href = `data:application/json,${encodeURIComponent(JSON.stringify(found, null, 1))}`; link.download = "push.json"; link.click();
  say(`Saved as push.json: jaxwalk render ${data.policy.quoted} --session push.json --out push.mp4`);
});

addEventListener("keydown", (event) => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, range = event.target.matches("input[type=range]");
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select, summary")) return;
  if (range && /^(Arrow|Page|Home|End)/.test(key)) return;
  if (!range && event.target.matches("button, input") && key === " ") return;
  const size = (by) => { impulse.value = Number(impulse.value) + by; showSize(); };
  const once = { ArrowRight: () => shove(1), ArrowLeft: () => shove(-1), " ": () => play(!playing), r: again, m: measure, Escape: letGo }[key];
  const often = { ArrowUp: () => size(10), ArrowDown: () => size(-10), ".": () => { play(false); advance(); } }[key];
  if (often) often(); else if (once && !event.repeat) once(); else if (!once) return;
  event.preventDefault();
});
for (const kind of ["input", "click", "keydown", "change"]) addEventListener(kind, () => { stale = true; });

// Beginning ----------------------------------------------------------------------------------------
/** Walk what a link tells of, at once up to a second before what was done last. */
function follow(found) {
  Object.assign(settings, found.settings);
  for (const input of byId("shown").querySelectorAll("input")) input.checked = found.shown.includes(input.value);
  begin(session(found.settings, found.shown), found.settings.seed);
  now.events = [...found.events]; ahead = [...found.events];
  const last = found.events.length ? found.events[found.events.length - 1][0] : 0;
  chased = Math.max(0, last - 1 / data.timestep);
  showSettings();
  say("As the link tells.");
}

function chase() {
  const end = performance.now() + SLICE, whole = chased;
  while (standing() && tick() < chased && performance.now() < end) advance();
  if (!standing()) chased = 0;
  say(tick() < chased ? `As the link tells: ${Math.round(100 * tick() / whole)} % of the way.` : "As the link tells.");
  stale = true;
}

function opened() {
  notice("");
  const text = location.hash.slice(1);
  if (!text) return false;
  try { follow(ofLink(text)); return true; } catch (error) { notice(`This link is not followed: ${error.message}. The walker starts anew.`); return false; }
}

async function main() {
  if (typeof WebAssembly !== "object") { notice("This browser has no WebAssembly, by which the walker is simulated: take one of 2023 or later."); return; }
  for (const [name, module] of Object.entries(data.modules)) machines[name] = await machine(module);
  chips(); makeSliders(); showSize(); begin(); opened();
  addEventListener("hashchange", () => { if (!opened()) begin(); });
  themed(() => { stale = true; });
  new ResizeObserver(() => { stale = true; }).observe(scene);
  play(!calm);
  requestAnimationFrame(frame);
  globalThis.jaxwalk = { data, machines, Walker, PushMap, walkers: () => walkers, session: () => written(now, tick()) };  // for whoever scripts the page
}
main().catch((error) => notice(`The walker cannot be simulated here: ${error.message}`));
