"""Train a network to answer as the rule `replan` does: the shipped policy, which can be exported.

    python scripts/imitate.py --out models/shipped.safetensors

The rule is asked about every state that walkers come to, pushed and unpushed, of many statures; in the first
round they follow the rule, in the later ones what has been learned so far, whose own mistakes it must know
how to answer (Ross, Gordon and Bagnell, "A reduction of imitation learning ...", 2011).
"""

from __future__ import annotations

import dataclasses
import shlex
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
import tyro

from jaxwalk.common import runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.ddpg import networks
from jaxwalk.learn.policies import policy
from jaxwalk.learn.train import finals
from jaxwalk.learn.train.evaluation import Exam
from jaxwalk.model import pushes
from jaxwalk.task import collect, rules, scenarios, stepper
from jaxwalk.task.rules import Replan
from jaxwalk.task.stepper import Stepper, Task


@dataclass(frozen=True)
class Args:
    """Imitate the rule."""

    out: Path = Path("shipped.safetensors")
    """Where the policy goes."""
    hidden: tuple[int, ...] = (64, 64)
    """Widths of its hidden layers."""
    rounds: int = 4
    """How often walkers are followed and the network is trained."""
    walkers: int = 2048
    """In a round."""
    seconds: float = 12.0
    """Each is followed."""
    impulse: float = 110.0
    """Largest push, either way, N s."""
    noise: float = 0.05
    """Spread of what is added to half of the walkers' answers, shares of half the range."""
    epochs: int = 12
    """Over all states so far, in each round."""
    batch: int = 4096
    """States of an update."""
    rate: float = 2e-3
    """Learning rate at first; it falls to nothing as a cosine."""
    seed: int = 0
    """Of all that is drawn."""


Network = tuple[networks.Params, jax.Array, jax.Array]


def answer(hidden: tuple[int, ...], network: Network, observation: jax.Array) -> jax.Array:
    """[..., 2] actions in [-1, 1] for raw observations."""
    actor, mean, std = network
    return networks.applied(networks.Actor(hidden, 2), actor, (observation - mean) / std)


def started(task: Task, config: Config, args: Args, key: jax.Array) -> Stepper:
    """A walker that will be pushed once."""
    start, size, build, when, how, height = jax.random.split(key, 6)
    stature = 1 + config.train.height_spread * jax.random.uniform(size, (), minval=-1.0)
    mass = config.body.mass * stature**3
    mass *= 1 + config.train.mass_spread * jax.random.uniform(build, (), minval=-1.0)
    state = stepper.start(
        task, config.gait, config.body.height * stature, mass, jnp.float32(config.sensors.noise), start
    )
    ratio, dt = state.walker.person.ratio, config.physics.timestep
    impulse = args.impulse * ratio.impulse * jax.random.uniform(how, (), minval=-1.0)
    begin = (jax.random.uniform(when, (), minval=1.0, maxval=6.0) / dt).astype(jnp.int32)
    above = config.pushes.height_spread * ratio.length * jax.random.uniform(height, (), minval=-1.0)
    push = pushes.of_impulse(impulse, begin, config.pushes.duration, dt, above)
    return state.replace(walker=state.walker.replace(push=push))


def followed(
    task: Task, args: Args, windows: int, act: Any, network: Any, states: Stepper, key: jax.Array
) -> Any:
    """[W, N, O] what the walkers saw when they were asked, and [W, N] whether they still walked."""
    count = states.observation.shape[0]
    shaken = args.noise * (jnp.arange(count) % 2)[:, None]

    def window(states: Stepper, key: jax.Array) -> tuple[Stepper, Any]:
        actions = act(network, states.observation) + shaken * jax.random.normal(key, (count, 2))
        told = states.observation, states.asked & ~states.done
        states = jax.vmap(stepper.decide)(states, actions)
        return jax.vmap(partial(collect.run_ticks, task, ticks=task.setup.window_ticks))(states), told

    return jax.lax.scan(window, states, jax.random.split(key, windows))[1]


def trained(args: Args, network: Network, seen: np.ndarray, wanted: np.ndarray) -> tuple[Network, float]:
    """The network after `epochs` over what was seen, and how far it is off, root mean square."""
    actor, mean, std = network
    batch = min(args.batch, len(seen))
    steps = args.epochs * (len(seen) // batch)
    adam = optax.adam(optax.cosine_decay_schedule(args.rate, steps))

    def loss(actor: Any, observation: jax.Array, action: jax.Array) -> jax.Array:
        return jnp.mean((answer(args.hidden, (actor, mean, std), observation) - action) ** 2)

    @jax.jit
    def epoch(carry: Any, order: jax.Array) -> Any:
        def update(carry: Any, index: jax.Array) -> Any:
            actor, state = carry
            value, slope = jax.value_and_grad(loss)(actor, observations[index], actions[index])
            change, state = adam.update(slope, state)
            return (optax.apply_updates(actor, change), state), value

        return jax.lax.scan(update, carry, order)

    observations, actions = jnp.asarray(seen), jnp.asarray(wanted)
    carry, rng, values = (actor, adam.init(actor)), np.random.default_rng(args.seed), np.zeros(1)
    for _ in range(args.epochs):
        order = rng.permutation(len(seen))[: len(seen) // batch * batch].reshape(-1, batch)
        carry, values = epoch(carry, jnp.asarray(order))
    return (carry[0], mean, std), float(np.sqrt(np.mean(values)))


def main(args: Args) -> None:
    """Follow, ask, train; examine what came of it beside the rule; save it."""
    rule = Replan()
    config = rules.configured(Config(), rule)
    config = dataclasses.replace(config, ddpg=dataclasses.replace(config.ddpg, hidden=args.hidden))
    task, person = Task.of(config), rules.reference(config.gait)
    windows = round(args.seconds / config.physics.timestep / config.train.window_ticks)
    by_rule = rules.strong(rule), person
    ruled = jax.jit(jax.vmap(lambda o: rules.act(by_rule, o)))
    start = jax.jit(jax.vmap(partial(started, task, config, args)))
    key = jax.random.key(args.seed)
    network: Any = None
    seen = np.zeros((0, len(config.observation)), np.float32)
    for turn in range(args.rounds):
        key, begin, walk = jax.random.split(key, 3)
        states = start(jax.random.split(begin, args.walkers))
        if network is None:
            act, params = jax.vmap(rules.act, (None, 0)), by_rule
        else:
            act, params = partial(answer, args.hidden), network
        told, up = jax.device_get(jax.jit(partial(followed, task, args, windows, act))(params, states, walk))
        seen = np.concatenate([seen, told[up]])
        if network is None:
            mean, std = seen.mean(0), seen.std(0) + 1e-6
            actor = networks.init_actor(args.hidden, begin, seen.shape[1], np.asarray(ruled(seen)).mean(0))
            network = actor, jnp.asarray(mean), jnp.asarray(std)
        network, off = trained(args, network, seen, np.asarray(ruled(seen)))
        print(f"round {turn}: {len(seen):,} states, off by {off:.4f}", flush=True)

    mesh = devices.mesh()
    marks = {}
    for name, act, params in (
        ("the rule", rules.act, by_rule), ("the network", partial(answer, args.hidden), network),
    ):  # fmt: skip
        exam = Exam(config, act, mesh, args.seed, scenarios.FINALS, finals.IMPULSES)
        marks[name] = exam(params)[0]
        print(name, marks[name], flush=True)
    actor, mean, std = network
    command = shlex.join(["python", *sys.argv])
    score = marks["the network"].score
    made = policy.of_parts(
        config, actor, mean, std, clip=None, seed=args.seed, command=command, footsteps=0, score=score
    )
    policy.save(made, args.out)


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
