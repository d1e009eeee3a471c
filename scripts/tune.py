"""Find the low-level controllers' numbers with CMA-ES, on the training physics.

Each candidate is a set of controller numbers together with a linear footstep rule
(length and duration from speed, pitch and step length): controllers are wanted
that a policy can use, not ones that walk best when the step is never adapted. The rule
is thrown away afterwards; that the fixed step walks too is part of the cost.

    python scripts/tune.py --generations 40 --out tuned.json
"""

from __future__ import annotations

import dataclasses
import json
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cmaes
import jax
import jax.numpy as jnp
import numpy as np
import tyro
from jax.sharding import AxisType, PartitionSpec

from jaxwalk import pushes, runtime, stepper, walker
from jaxwalk.config import Config

# name: (least, most); CMA-ES works on the unit cube.
GAIT = {
    "length_nominal": (0.5, 1.2),
    "duration_nominal": (0.12, 0.3),
    "pitch_nominal": (0.03, 0.2),
    "stance_speed_min": (0.2, 1.2),
    "stance_rate_max": (3.0, 9.0),
    "swing_rate_max": (5.0, 12.0),
    "swing_pitch_gain": (-1.0, 1.5),
    "swing_knee": (0.7, 1.5),
    "swing_knee_share": (0.4, 0.9),
    "swing_ankle": (0.0, 0.5),
    "terminal_hip_gain": (0.0, 12.0),
    "toe_off_duration": (0.022, 0.08),
    "toe_off_duration_max": (0.022, 0.2),
    "toe_off_base": (20.0, 130.0),
    "toe_off_gain": (0.0, 800.0),
    "touchdown_share": (0.4, 1.0),
}
# Change of (length m, duration s) for one unit of: speed above and below its usual value (m/s;
# pushes from behind and from the front want different answers), pitch (rad), step length (m).
USUAL = np.array([1.3, 0.1, 0.55], np.float32)
RULE = np.array([[1.0, 1.0, 2.0, 1.0], [0.4, 0.4, 0.5, 0.3]], np.float32)  # widest gains
WALK_SECONDS, SECONDS = 1.4, 4.4
PHASES = 8
IMPULSES = (50.0, 65.0, 80.0, -35.0, -50.0, -65.0)


@dataclass(frozen=True)
class Args:
    """Options."""

    out: Path = Path("tuned.json")
    """Where the best numbers go (JSON)."""
    generations: int = 40
    """CMA-ES generations."""
    population: int = 16
    """Candidates a generation; a multiple of the devices."""
    sigma: float = 0.15
    """First step size, share of each range."""
    seed: int = 0
    """Of CMA-ES and of the scenarios."""
    start: Path | None = None
    """A tuned.json to begin from."""


def scenarios() -> dict[str, np.ndarray]:
    """[S] impulse, phase and whether the rule may act: pushed with it; unpushed and mildly pushed without."""
    rows = [(impulse, phase / PHASES, 1.0) for impulse in IMPULSES for phase in range(PHASES)]
    rows += [(0.0, 0.0, 1.0)] * 6 + [(0.0, 0.0, 0.0)] * 6
    rows += [(impulse, phase / 4, 0.0) for impulse in (30.0, -20.0) for phase in range(4)]
    impulse, phase, adapts = np.array(rows, np.float32).T
    return {"impulse": impulse, "phase": phase, "adapts": adapts}


def unpack(config: Config, unit: jax.Array):
    """Controller numbers and the [2, 4] rule of one candidate."""
    values = {name: low + (high - low) * unit[i] for i, (name, (low, high)) in enumerate(GAIT.items())}
    rule = (2 * unit[len(GAIT) :].reshape(2, 4) - 1) * RULE
    return dataclasses.replace(config.gait, **values), rule


def episode(setup: walker.Setup, config: Config, unit, scenario, key):
    """One walker through one scenario: (life in s, mean speed in m/s, mean squared pitch wobble)."""
    numbers, rule = unpack(config, unit)
    who = walker.person(numbers, jnp.float32(config.body.height), jnp.float32(config.body.mass))
    model = walker.model(setup, who)
    state = walker.start(setup, who, key, jnp.float32(config.sensors.noise))
    begin = jnp.int32((WALK_SECONDS + 0.6 * scenario["phase"]) / setup.timestep)
    state = state.replace(
        push=pushes.of_impulse(scenario["impulse"], begin, 0.1, setup.timestep, jnp.float32(0))
    )

    def tick(carry, _):
        state, alive, life, speed, wobble, when = carry
        after, event = walker.tick(setup, model, state)
        alive = alive & ~event.fell
        told = jnp.stack([after.estimate.speed, after.estimate.pitch, event.step_length]) - USUAL
        told = jnp.concatenate([jnp.maximum(told[:1], 0), jnp.minimum(told[:1], 0), told[1:]])
        change = rule @ told * scenario["adapts"]
        action = jnp.clip(
            jnp.stack([numbers.length_nominal, numbers.duration_nominal]) + change,
            jnp.stack([numbers.length_min, numbers.duration_min]),
            jnp.stack([numbers.length_max, numbers.duration_max]),
        )
        after = stepper.select(event.touchdown, walker.decide(after, action), after)
        # A fallen walker stays frozen; its NaNs must not spread.
        state = stepper.select(alive, after, state)
        dt = alive * setup.timestep
        speed += dt * state.plant.qvel[0]
        wobble += dt * (state.plant.qpos[2] - 0.08) ** 2
        return (state, alive, life + dt, speed, wobble, when), None

    zero = jnp.zeros(())
    first = (state, jnp.bool_(True), zero, zero, zero, begin)
    (_, alive, life, speed, wobble, _), _ = jax.lax.scan(tick, first, length=int(SECONDS / setup.timestep))
    return {
        "alive": alive,
        "life": life,
        "speed": speed / jnp.maximum(life, setup.timestep),
        "wobble": wobble / jnp.maximum(life, setup.timestep),
    }


def evaluator(config: Config):
    """units [P, D], key -> results [P, S], candidates sharded over devices."""
    setup = walker.Setup.of(config)
    table = {k: jnp.asarray(v) for k, v in scenarios().items()}
    count = len(table["impulse"])

    def candidate(unit, keys):
        return jax.vmap(partial(episode, setup, config, unit))(table, keys)

    mesh = jax.make_mesh((jax.device_count(),), ("p",), axis_types=(AxisType.Auto,))
    spec = PartitionSpec("p")
    run = jax.shard_map(
        jax.vmap(candidate, in_axes=(0, None)),
        mesh=mesh,
        in_specs=(spec, PartitionSpec()),
        out_specs=spec,
        check_vma=False,
    )
    run = jax.jit(run)
    return lambda units, key: jax.device_get(run(units, jax.random.split(key, count))), scenarios()


def cost(results: dict[str, np.ndarray], table: dict[str, np.ndarray]) -> np.ndarray:
    """[P] lower is better: falls first (later ones a little better), then speed and pitch."""
    alive, life = results["alive"].astype(float), results["life"]
    loss = (1 - alive) * (1.3 - 0.3 * life / SECONDS)
    calm = table["impulse"] == 0
    weight = np.where(calm, 3.0, 1.0)
    falls = (loss * weight).sum(1) / weight.sum()
    off = np.abs(results["speed"][:, calm].mean(1) - 1.0)
    # The nominal step alone is to keep the speed as well.
    return falls + 2.0 * np.maximum(off - 0.01, 0) + 1.0 * np.sqrt(results["wobble"][:, calm].mean(1))


def main(args: Args) -> None:
    runtime.setup()
    config = Config()
    evaluate, table = evaluator(config)
    default = [(getattr(config.gait, n) - low) / (high - low) for n, (low, high) in GAIT.items()]
    mean = np.array(default + [0.5, 0.6, 0.5, 0.5] + [0.35, 0.5, 0.5, 0.5])
    if args.start:
        mean = np.array(json.loads(args.start.read_text())["unit"])
    bounds = np.tile([0.0, 1.0], (len(mean), 1))
    search = cmaes.CMA(
        mean=mean, sigma=args.sigma, bounds=bounds, population_size=args.population, seed=args.seed
    )
    for generation in range(args.generations):
        started = time.perf_counter()
        units = np.stack([search.ask() for _ in range(args.population - 1)] + [search.mean])
        units = np.clip(units, 0, 1)
        results = evaluate(jnp.asarray(units, jnp.float32), jax.random.key(args.seed * 1000 + generation))
        costs = cost(results, table)
        extra = search.ask()  # CMA-ES wants a full population; the mean itself is only watched
        search.tell([*zip(units[:-1], costs[:-1], strict=True), (extra, float(costs[:-1].max()))])
        mine = {i: results["alive"][-1][table["impulse"] == i].mean() for i in (0.0, *IMPULSES)}
        speed = results["speed"][-1][table["impulse"] == 0].mean()
        fixed = results["alive"][-1][table["adapts"] == 0].mean()
        print(
            f"{generation:3d} best {costs.min():.3f} mean's {costs[-1]:.3f} speed {speed:.2f} "
            + " ".join(f"{i:+.0f}:{s:.2f}" for i, s in mine.items())
            + f"  fixed {fixed:.2f} {time.perf_counter() - started:.0f}s",
            flush=True,
        )
        numbers, rule = unpack(config, jnp.asarray(search.mean, jnp.float32))
        args.out.write_text(
            json.dumps(
                {
                    "generation": generation,
                    "gait": {n: round(float(getattr(numbers, n)), 4) for n in GAIT},
                    "rule": np.asarray(rule).round(4).tolist(),
                    "unit": search.mean.tolist(),
                },
                indent=1,
            )
        )


if __name__ == "__main__":
    main(tyro.cli(Args, description=__doc__))
