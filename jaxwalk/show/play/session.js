// What was done to a walker: its settings, and what came when, as a link and as a file.
const FORMAT = 1;
const MOST = 500;                 // things that may happen in one session
const LONGEST = 600;              // s that a session may last
const AFTER = 10;                 // s

/** A session that begins; `events`: [tick, what]. */
function session(settings, shown) {
  return { settings: { ...settings }, shown: [...shown], events: [] };
}

/** Written down, for a link or a file: up to now, but no more than `AFTER` past what was done last. */
function written(now, ticks) {
  const events = now.events.filter(([at]) => at <= ticks), last = events.length ? events[events.length - 1][0] : 0;
  const whole = Math.min(ticks, last + AFTER / data.timestep), { name, digest } = data.policy;
  return { format: FORMAT, made_by: "jaxwalk play", jaxwalk: data.version, policy: { name, digest }, shown: now.shown, settings: now.settings, events, ticks: whole };
}

function linkOf(session) {
  const text = new TextEncoder().encode(JSON.stringify(session));
  return btoa(String.fromCharCode(...text)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** The session of a link; throws one line that says what is wrong with it. */
function ofLink(text) {
  let found;
  try {
    const bytes = bytesOf(text.replaceAll("-", "+").replaceAll("_", "/"));
    found = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch { throw new Error("it is cut off or damaged"); }
  return checked(found);
}

/** `found` as a session, made anew of what is known alone. */
function checked(found) {
  const wrong = (what) => { throw new Error(`it ${what}`); };
  const object = (x) => x !== null && typeof x === "object" && !Array.isArray(x);
  const own = (x, name) => (Object.hasOwn(x, name) ? x[name] : undefined);
  const shownAs = (x) => String(typeof x === "object" ? JSON.stringify(x) : x).slice(0, 40);
  const real = (x) => typeof x === "number" && Number.isFinite(x);
  if (!object(found) || found.format !== FORMAT || !object(found.settings) || !Array.isArray(found.events)) wrong("is not one of this kind of page");
  if (!object(found.policy) || found.policy.digest !== data.policy.digest) wrong(`is of another policy than ${data.policy.name}`);
  const names = data.controllers.map((c) => c.name), { shown, ticks } = found;
  if (!Array.isArray(shown) || !shown.length || shown.some((name, i) => !names.includes(name) || shown.indexOf(name) !== i)) wrong(`shows who is not here: give of ${names.join(", ")}`);
  const within = (name, value) => {
    const { low, high, unit, times = 1 } = data.sliders[name];
    if (!real(value)) wrong(`asks for a ${name} of ${shownAs(value)}: give a number`);
    if (value < low || value > high) wrong(`asks for a ${name} of ${number(value * times)}: ${number(low * times)} to ${number(high * times)} ${unit} are possible`.trimEnd());
    return value;
  };
  const settings = Object.fromEntries(Object.keys(data.sliders).map((name) => [name, within(name, own(found.settings, name))]));
  settings.seed = own(found.settings, "seed");
  if (!Number.isInteger(settings.seed) || settings.seed < 0 || settings.seed >= 2 ** 32) wrong("has no seed");
  if (!Number.isInteger(ticks) || ticks < 0) wrong("does not say how long it is");
  if (ticks * data.timestep > LONGEST) wrong(`walks for longer than ${LONGEST} s: start anew`);
  if (found.events.length > MOST) wrong(`has more than ${MOST} events`);
  const shove = (x) => {
    const { impulse, height = 0, place = 0 } = object(x) ? x : {};
    if (!real(impulse) || Math.abs(impulse) > data.most || !real(height) || Math.abs(height) > 1 || ![0, 1, 2, 3, 4].includes(place)) wrong(`has a push that is none: within ${data.most} N s`);
    return { impulse, height, place };
  };
  let before = 0;
  const events = found.events.map((event) => {
    const [tick, what] = Array.isArray(event) ? event : [];
    if (!Number.isInteger(tick) || tick < before || tick > ticks || tick % data.window || !object(what)) wrong("has events out of order");
    before = tick;
    return [tick, Object.fromEntries(Object.entries(what).map(([name, value]) => {
      if (name === "push") return [name, shove(value)];
      if (!Object.hasOwn(data.sliders, name) || data.sliders[name].fixed) wrong(`has an event that is unknown: ${shownAs(name)}`);
      return [name, within(name, value)];
    }))];
  });
  return { shown: [...shown], settings, events, ticks };
}

/** Let what comes at its tick come to a walker, under `settings`, which change with it. */
function happen(what, walker, settings) {
  const { push, ...changed } = what;
  Object.assign(settings, changed);
  if (Object.keys(changed).length) walker.meet(settings);
  if (push) walker.push(push);
}
