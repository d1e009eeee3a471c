// A push map of the very walker on the page: phase of the step x impulse, one push each, while one waits.
const PHASES = 16;
const IMPULSES = [-140, -120, -100, -80, -60, -40, -20, 20, 40, 60, 80, 100, 120, 140, 160];  // N s
const SETTLE = 3, WAIT = 4;       // s of walking before a push, and after it

/** Measure in slices; `cells[impulse][phase]`: true walks on, false does not, undefined: not known yet. */
class PushMap {
  constructor(made, controller, page) {
    this.walker = new Walker(made, controller, page);
    this.forget();
  }

  forget() { Object.assign(this, { cells: null, work: null, impulses: IMPULSES }); }

  begin(settings) {
    this.settings = { ...settings };
    this.cells = IMPULSES.map(() => new Array(PHASES));
    this.windows = this.spent = 0;
    this.work = this.measured();
  }

  /** Measure for about `ms`; whether there is more to do. */
  slice(ms) {
    const begun = performance.now(), windows = this.windows;
    while (this.work && performance.now() < begun + ms) {
      if (this.work.next().done) this.work = null;
      this.windows++;
    }
    if (this.windows > windows) this.spent += performance.now() - begun;
    return this.work !== null;
  }

  /** Ticks a second, of those that were walked for it. */
  get rate() { return this.windows * this.walker.page.window / this.spent * 1000; }

  get share() {
    return this.cells ? this.cells.flat().filter((x) => x !== undefined).length / (IMPULSES.length * PHASES) : 0;
  }

  *measured() {
    const { walker } = this, { timestep, window: length } = walker.page;
    walker.start(this.settings);
    // Of a heavier or taller body, as dynamic similarity has it, in whole 5 N s.
    const scale = walker.number("walker.person.ratio.mass") * Math.sqrt(walker.size);
    this.impulses = IMPULSES.map((impulse) => Math.round(impulse * scale / 5) * 5);
    let before = walker.whole("walker.gait.stance");
    while (!walker.done) {   // to the first landing after it has settled
      walker.window(); yield;
      const stance = walker.whole("walker.gait.stance");
      if (walker.time > SETTLE && stance !== before) break;
      before = stance;
    }
    const landed = walker.kept(), begun = walker.tick - Math.round(walker.number("walker.gait.elapsed") / timestep);
    const ticks = walker.number("last.seconds") / timestep;
    // Small pushes first: what is known soonest is what most ask for.
    const order = [...IMPULSES.keys()].sort((a, b) => Math.abs(IMPULSES[a]) - Math.abs(IMPULSES[b]));
    for (const row of order) for (let phase = 0; phase < PHASES; phase++) {
      walker.restore(landed);
      const begin = Math.max(walker.tick, begun + Math.round(phase / PHASES * ticks));
      walker.push({ impulse: this.impulses[row] }, begin);
      for (let k = Math.ceil((begin - walker.tick + WAIT / timestep) / length); k > 0 && !walker.done; k--) { walker.window(); yield; }
      this.cells[row][phase] = walker.walksOn;
    }
  }


  /** The cell of a push, [row, column], if it has one. */
  cell(phase, impulse) {
    const all = this.impulses, row = all.reduce((best, x, i) => (Math.abs(x - impulse) < Math.abs(all[best] - impulse) ? i : best), 0);
    const beyond = Math.abs(impulse) > Math.abs(all[row]) + Math.abs(all[0] - all[1]) / 2;
    return phase === null || beyond ? null : [row, Math.round(phase * PHASES) % PHASES];
  }

  /** What is known of a push, by the cell that is nearest. */
  at(phase, impulse) {
    const place = this.cells && this.cell(phase, impulse);
    return place ? this.cells[place[0]][place[1]] : undefined;
  }
}
