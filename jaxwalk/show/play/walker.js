// The simulation: compiled walkers and their memory.
const WORD = 4;                   // bytes of a number

/** The bytes of a text in base64. */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

/** A module that is ready to hold walkers; `kept` as the page's data have it. */
async function machine(kept) {
  const imports = { env: { sinf: Math.sin, cosf: Math.cos, powf: Math.pow, fmodf: (a, b) => a % b } };
  const { instance } = await WebAssembly.instantiate(bytesOf(kept.code), imports);
  const { memory, __heap_base, start, window: walk } = instance.exports;
  const size = (places) => Math.max(...Object.values(places).map(([at, shape]) => at + shape.reduce((a, b) => a * b, 1)));
  let free = Math.ceil(__heap_base.value / 16) * 16;
  const room = (words) => {
    const at = free;
    free = Math.ceil((free + words * WORD) / 16) * 16;
    if (free > memory.buffer.byteLength) memory.grow(Math.ceil((free - memory.buffer.byteLength) / 65536));
    return at;
  };
  return { memory, start, walk, room, given: kept.given, state: kept.state, givens: size(kept.given), words: size(kept.state) };
}

/** One walker under one controller. */
class Walker {
  /** @param made what `machine` gives. @param controller as the page's data have it. */
  constructor(made, controller, page) {
    Object.assign(this, { made, controller, page });
    this.at = made.room(made.words);
    this.givenAt = made.room(made.givens);
    const answers = new Float32Array(bytesOf(controller.answers).buffer);
    this.netAt = made.room(answers.length);
    new Float32Array(made.memory.buffer, this.netAt, answers.length).set(answers);
    this.numbers = new Float32Array(bytesOf(controller.numbers).buffer);
  }

  view(kind, base, [at, shape]) {
    return new kind(this.made.memory.buffer, base + at * WORD, Math.max(1, shape.reduce((a, b) => a * b, 1)));
  }

  /** A float, or several, of the state, by name. */
  floats(name) { return this.view(Float32Array, this.at, this.made.state[name]); }
  whole(name) { return this.view(Int32Array, this.at, this.made.state[name])[0]; }
  number(name) { return this.floats(name)[0]; }
  setWhole(name, value) { this.view(Int32Array, this.at, this.made.state[name])[0] = value; }
  setNumber(name, value) { this.floats(name)[0] = value; }

  /** Begin anew, as `settings` have it. */
  start(settings) {
    const { made } = this, give = (name, value) => { this.view(Float32Array, this.givenAt, made.given[name])[0] = value; };
    new Float32Array(made.memory.buffer, this.givenAt, made.givens).set(this.numbers);
    give("height", settings.height); give("mass", settings.mass); give("noise", settings.noise);
    give("numbers.speed_desired", settings.speed);
    for (const [name, value] of Object.entries(burdenOf(settings))) give(`burden.${name}`, value);
    this.view(Uint32Array, this.givenAt, made.given.seed)[0] = settings.seed;
    made.start(this.at, this.givenAt);
    Object.assign(this, { fell: null, last: null, prints: [], steps: [], pushes: [], seen: [] });
    this.look();
  }

  /** What may change while it walks. */
  meet(settings) {
    this.setNumber("walker.person.gait.speed_desired", settings.speed);
    this.setNumber("walker.sensors.noise", settings.noise);
    for (const [name, value] of Object.entries(burdenOf(settings))) this.setNumber(`walker.person.burden.${name}`, value);
  }

  /** Be pushed from tick `begin` on: N s, m above the torso's centre, and an index into the places of a push. */
  push({ impulse, height = 0, place = 0 }, begin = this.tick) {
    const ticks = Math.max(1, Math.round(this.page.push / this.page.timestep));
    this.setWhole("walker.push.start", begin);
    this.setWhole("walker.push.ticks", ticks);
    this.setNumber("walker.push.force", impulse / (ticks * this.page.timestep));
    this.setNumber("walker.push.height", height);
    this.setWhole("walker.push.place", place);
  }

  /** One decision window further; nothing after a fall. */
  window() {
    if (this.done) return;
    this.made.walk(this.at, this.netAt);
    this.look();
  }

  look() {
    this.tick = this.whole("walker.tick");
    this.done = this.whole("terminated") !== 0;
  }

  get time() { return this.tick * this.page.timestep; }
  get pose() { return this.floats("walker.plant.qpos"); }
  get speed() { return this.number("walker.sensors.last_velocity"); }
  get size() { return this.number("walker.person.ratio.length"); }
  get pushed() { const begin = this.whole("walker.push.start"); return this.tick >= begin && this.tick < begin + this.whole("walker.push.ticks"); }

  /** Whether it still goes somewhere: half the speed asked for in its last step at least. */
  get walksOn() {
    return !this.done && this.number("last.speed") >= 0.5 * this.number("walker.person.gait.speed_desired");
  }

  /** Where in its step it is, from 0 up to 1, of a step as long as its last one; null where there is none to tell by. */
  get phase() {
    const share = this.number("walker.gait.elapsed") / this.number("last.seconds");
    return share < 1 ? share : null;
  }

  /** Where a foot would bring it to rest, m along the floor. */
  get capture() {
    const { leg, torso, share } = this.page.body, [x, , pitch] = this.pose;
    return x + this.size * torso * share * Math.sin(pitch) + this.speed * Math.sqrt(this.size * leg / this.page.gravity);
  }

  /** Why it is over, in words. */
  get reason() {
    if (this.whole("broken")) return "its numbers broke";
    const [, height, pitch] = this.pose, own = (name) => this.number(`walker.person.gait.${name}`);
    if (Math.abs(pitch) > own("fall_pitch")) return `its torso tipped ${pitch > 0 ? "forward" : "back"}`;
    if (height < own("fall_height") * this.size * this.page.body.leg) return "its hip sank";
    return "it took no step for too long";
  }

  /** All of its state, to come back to. */
  kept() { return new Uint32Array(this.made.memory.buffer, this.at, this.made.words).slice(); }
  restore(kept) { new Uint32Array(this.made.memory.buffer, this.at, this.made.words).set(kept); this.look(); }
}

/** What its controllers do not know of, by the names of a burden. */
function burdenOf({ slope, friction, strength, delay }) {
  return { slope: slope * Math.PI / 180, friction, strength, delay };
}
