// What was done to a walker: its settings, and what came when, as a link and as a file.
const FORMAT = 1;
const MOST = 500;                 // things that may happen in one session
const LONGEST = 600;              // s that a link may take to walk again

/** A session that begins; `events`: [tick, what]. */
function session(settings, shown) {
  return { settings: { ...settings }, shown: [...shown], events: [] };
}

/** Written down, for a link or a file. */
function told(now, ticks) {
  return { format: FORMAT, made_by: "jaxwalk play", jaxwalk: data.version, policy: data.policy, shown: now.shown, settings: now.settings, events: now.events, ticks };
}

function linkOf(now, ticks) {
  const text = new TextEncoder().encode(JSON.stringify(told(now, ticks)));
  return btoa(String.fromCharCode(...text)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** What a link says; throws one line that says what is wrong with it. */
function ofLink(text) {
  let found;
  try {
    const bytes = bytesOf(text.replaceAll("-", "+").replaceAll("_", "/"));
    found = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch { throw new Error("this link is cut off or damaged"); }
  return checked(found);
}

function checked(found) {
  const wrong = (what) => { throw new Error(`this link ${what}`); };
  const object = (x) => x !== null && typeof x === "object" && !Array.isArray(x);
  if (!object(found) || found.format !== FORMAT || !object(found.settings) || !Array.isArray(found.events)) wrong("is not one of this kind of page");
  if (!object(found.policy) || found.policy.digest !== data.policy.digest) wrong(`is of another policy than ${data.policy.name}`);
  const names = data.controllers.map((c) => c.name);
  if (!Array.isArray(found.shown) || !found.shown.length || found.shown.some((name, i) => !names.includes(name) || found.shown.indexOf(name) !== i)) wrong(`shows who is not here: give of ${names.join(", ")}`);
  const within = (name, value) => {
    const { low, high, unit } = data.sliders[name];
    if (!Number.isFinite(value) || value < low || value > high) wrong(`asks for a ${name} of ${value}: ${low} to ${high} ${unit} are possible`.trimEnd());
  };
  for (const name of Object.keys(data.sliders)) within(name, found.settings[name]);
  if (!Number.isInteger(found.settings.seed) || found.settings.seed < 0 || found.settings.seed >= 2 ** 32) wrong("has no seed");
  if (!Number.isInteger(found.ticks) || found.ticks < 0 || found.ticks * data.timestep > LONGEST) wrong(`walks for longer than ${LONGEST} s`);
  if (found.events.length > MOST) wrong(`has more than ${MOST} events`);
  let before = 0;
  for (const event of found.events) {
    const [tick, what] = Array.isArray(event) ? event : [];
    if (!Number.isInteger(tick) || tick < before || tick > found.ticks || tick % data.window || !object(what)) wrong("has events out of order");
    before = tick;
    for (const [name, value] of Object.entries(what)) {
      if (name in data.sliders && !data.sliders[name].fixed) within(name, value);
      else if (name !== "push" || !object(value)) wrong(`has an event that is unknown: ${name}`);
      else if (!Number.isFinite(value.impulse) || Math.abs(value.impulse) > data.most || !(Math.abs(value.height ?? 0) <= 1) || ![0, 1, 2, 3, 4].includes(value.place ?? 0)) wrong(`has a push that is none: within ${data.most} N s`);
    }
  }
  return found;
}

/** Let what comes at its tick come to a walker, under `settings`, which change with it. */
function happen(what, walker, settings) {
  const { push, ...changed } = what;
  Object.assign(settings, changed);
  if (Object.keys(changed).length) walker.meet(settings);
  if (push) walker.push(push);
}
