"""Brax's PPO and SAC on the same task, as baselines for our learner; the result is an ordinary run folder.

They start where `jaxwalk train` starts, near the nominal step, see the same bodies, pushes, rewards and
discount, have networks of the same widths, and the best of as many evaluations is kept.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from brax.training import acting
from brax.training.agents.ppo import networks as ppo_networks
from brax.training.agents.ppo import train as ppo
from brax.training.agents.sac import networks as sac_networks
from brax.training.agents.sac import train as sac
from flax import linen
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from jaxwalk.common.errors import UserError
from jaxwalk.common.interrupt import Stop
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.brax.options import PPO, SAC, PPOArgs, SACArgs
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train.examined import Examined
from jaxwalk.task import footstep, rules
from jaxwalk.task.env import FootstepEnv

EPISODE = 64  # footsteps, about 30 s
_SMALL = 0.01  # of the last layer's first weights: the first policy answers alike everywhere

# What Brax's trainers hand out: normaliser, policy, and PPO's value function, which nobody needs.
BraxParams = tuple[Any, ...]
Report = Callable[[int, Mapping[str, Any]], None]  # decisions so far, metrics and ``params``


def decisions(config: Config) -> int:
    """How often a step of the nominal duration is decided. Brax counts, and discounts, decisions."""
    if not config.task.replan:
        return 1
    seconds = config.task.replan * config.train.window_ticks * config.physics.timestep
    return max(1, round(config.gait.duration_nominal / seconds))


def convert(config: Config, params: BraxParams, **origin: Any) -> Policy:
    """The deterministic policy tanh(loc) of Brax's PPO or SAC as one of ours.

    Args:
      params: normaliser and policy, of networks made by `_ppo_networks` or `_sac_networks`.
      origin: seed, command, footsteps and score for the policy's metadata.
    """
    statistics, layers = params[0], params[1]["params"]
    names = [f"hidden_{i}" for i in range(len(layers))]
    actor = {name: dict(layers[name]) for name in names[:-1]}
    actions = len(footstep.ACTIONS)  # locations come first, then scales
    actor["output"] = {leaf: layers[names[-1]][leaf][..., :actions] for leaf in ("kernel", "bias")}
    return policy.of_parts(config, actor, statistics.mean, statistics.std, clip=None, **origin)


class _Handing:
    """In place of Brax's evaluator, whose episodes meet no graded pushes: hands the parameters on."""

    def __init__(self, *args: Any, **options: Any) -> None:
        pass

    def run_evaluation(self, params: BraxParams, training_metrics: Mapping[str, Any]) -> dict[str, Any]:
        """What Brax then tells its ``progress_fn``: the metrics, and under ``params`` what they came from."""
        return {**training_metrics, "params": params}


@contextlib.contextmanager
def trainable() -> Iterator[None]:
    """Within it, Brax's trainers run on today's JAX, and their ``progress_fn`` is told the parameters.

    ``jax.device_put_replicated``, which they call, is gone (google/brax#671). SAC hands its parameters
    to nobody but its evaluator.
    """
    changes: list[tuple[Any, str, Any]] = [(acting, "Evaluator", _Handing)]
    if not hasattr(jax, "device_put_replicated"):
        changes.append((jax, "device_put_replicated", _device_put_replicated))
    before = [vars(module).get(name) for module, name, _ in changes]
    try:
        for module, name, ours in changes:
            setattr(module, name, ours)
        yield
    finally:
        for (module, name, _), theirs in zip(changes, before, strict=True):
            if theirs is None:
                delattr(module, name)
            else:
                setattr(module, name, theirs)


def _device_put_replicated(tree: Any, where: list[Any]) -> Any:
    """A copy of ``tree`` for each device, along a new first axis, as ``jax.pmap`` wants it."""
    sharding = NamedSharding(Mesh(np.array(where), ("device",)), PartitionSpec("device"))

    def put(leaf: Any) -> jax.Array:
        leaf = jnp.asarray(leaf)
        return jax.device_put(jnp.broadcast_to(leaf, (len(where), *leaf.shape)), sharding)

    return jax.tree.map(put, tree)


def _near(networks: Any, action: jax.Array, std: float) -> Any:
    """``networks`` whose first policy is close to ``action`` everywhere, with ``std`` before tanh."""
    scale = math.log(math.expm1(std))  # Brax's standard deviation is softplus of it
    bias = jnp.concatenate([jnp.arctanh(action), jnp.full(action.shape, scale)])
    inner = networks.policy_network

    def init(key: jax.Array) -> Any:
        params = inner.init(key)
        layers = params["params"]
        last = f"hidden_{len(layers) - 1}"
        output = {"kernel": _SMALL * layers[last]["kernel"], "bias": bias.astype(jnp.float32)}
        return {**params, "params": {**layers, last: output}}

    return networks.replace(policy_network=dataclasses.replace(inner, init=init))


def _ppo_networks(config: Config, std: float, *args: Any, **options: Any) -> ppo_networks.PPONetworks:
    hidden = config.ddpg.hidden
    made = ppo_networks.make_ppo_networks(
        *args,
        policy_hidden_layer_sizes=hidden,
        value_hidden_layer_sizes=hidden,
        activation=linen.relu,
        **options,
    )
    return _near(made, rules.nominal(config), std)


def _sac_networks(config: Config, std: float, *args: Any, **options: Any) -> sac_networks.SACNetworks:
    made = sac_networks.make_sac_networks(
        *args, hidden_layer_sizes=config.ddpg.hidden, activation=linen.relu, **options
    )
    return _near(made, rules.nominal(config), std)


def _ppo(config: Config, settings: PPO, seed: int, footsteps: int, evaluations: int, report: Report) -> None:
    ppo.train(
        FootstepEnv(config),
        num_timesteps=footsteps * decisions(config),
        num_evals=evaluations + 1,
        episode_length=EPISODE * decisions(config),
        num_envs=settings.walkers,
        unroll_length=settings.unroll_length,
        batch_size=settings.batch_size,
        num_minibatches=settings.minibatches,
        num_updates_per_batch=settings.epochs,
        learning_rate=settings.learning_rate,
        clipping_epsilon=settings.clipping,
        gae_lambda=settings.gae_lambda,
        entropy_cost=settings.entropy_cost,
        discounting=config.ddpg.gamma ** (1 / decisions(config)),
        normalize_observations=True,
        network_factory=partial(_ppo_networks, config, settings.first_std),
        progress_fn=report,
        seed=seed,
    )


def _sac(config: Config, settings: SAC, seed: int, footsteps: int, evaluations: int, report: Report) -> None:
    sac.train(
        FootstepEnv(config),
        num_timesteps=footsteps * decisions(config),
        num_evals=evaluations + 1,
        episode_length=EPISODE * decisions(config),
        num_envs=settings.walkers,
        grad_updates_per_step=max(
            1, round(settings.walkers * settings.updates_per_footstep / decisions(config))
        ),
        batch_size=settings.batch_size,
        learning_rate=settings.learning_rate,
        tau=settings.tau,
        min_replay_size=settings.warmup * decisions(config),
        reward_scaling=settings.reward_scaling,
        discounting=config.ddpg.gamma ** (1 / decisions(config)),
        normalize_observations=True,
        network_factory=partial(_sac_networks, config, settings.first_std),
        progress_fn=report,
        seed=seed,
    )


class _Ended(Exception):
    """Ctrl-C was pressed; what was kept so far stands."""


def train(config: Config, args: PPOArgs | SACArgs, command: str) -> Path:
    """Train, and return the run folder.

    Ctrl-C (or SIGTERM, SIGHUP) ends at the next evaluation and keeps the best policy so far.

    Raises:
      UserError: a folder that cannot be used, or walkers that the devices cannot share.
    """
    settings = args.settings
    if settings.walkers % jax.local_device_count():
        raise UserError(
            f"--walkers {settings.walkers}: give a multiple of the {jax.local_device_count()} devices"
        )
    size = dict(footsteps=args.footsteps, evaluations=args.evaluations, walkers=settings.walkers)
    config = replace(config, train=replace(config.train, **size))
    with RunFolder.create(args.run_dir, config, args.seed, command) as folder:
        print(f"run folder {folder.path}", flush=True)
        with Progress(args.footsteps) as progress, Stop() as stop, trainable():
            examined = Examined(config, devices.mesh(), args.seed, folder, progress, stop)

            def report(decided: int, metrics: Mapping[str, Any]) -> None:
                origin = dict(seed=args.seed, command=command, footsteps=decided // decisions(config))
                handed = convert(config, metrics["params"], **origin, score=None)
                told = {name: float(x) for name, x in metrics.items() if name.startswith("training/")}
                if examined.report(handed, told):
                    raise _Ended

            rest = args.seed, args.footsteps, args.evaluations, report
            with contextlib.suppress(_Ended):
                if isinstance(settings, PPO):
                    _ppo(config, settings, *rest)
                else:
                    _sac(config, settings, *rest)
            name = "ppo" if isinstance(settings, PPO) else "sac"
            examined.finish({"algorithm": name, "settings": asdict(settings)})
        return folder.path
