"""Several trainings inside one program, each in a lane of its own.

Lanes are spread over the devices first, which then never wait for each other; a device's own lanes are
mapped over by `jax.vmap`, on a CPU one after another: there a batch of lanes is no faster than its lanes,
and leaves the cache. A lane that is not live stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import AxisType, Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Bool

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.train import device_loop
from jaxwalk.learn.train.device_loop import TrainState
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Act, Params, Runner, Trial

AXIS = "lanes"
T = TypeVar("T")


def mesh(count: int) -> Mesh:
    """The devices that ``count`` lanes can use, along `AXIS`; each is alone along `devices.AXIS`."""
    used = min(count, jax.device_count())
    return jax.make_mesh(
        (used, 1), (AXIS, devices.AXIS), axis_types=(AxisType.Auto,) * 2, devices=jax.devices()[:used]
    )


def filled(lanes: Sequence[T], mesh: Mesh) -> list[T]:
    """Lanes that all devices have equally many of: those beyond ``lanes`` repeat the last, and never live."""
    return [*lanes, *[lanes[-1]] * (-len(lanes) % mesh.size)]


def flags(live: Sequence[bool], mesh: Mesh) -> np.ndarray:
    """Which of the `filled` lanes are live."""
    return np.array([*live, *[False] * (-len(live) % mesh.size)])


def one_by_one() -> bool:
    """Whether lanes of a device take turns."""
    return jax.default_backend() == "cpu"


def each(function: Callable[..., T], live: Bool[Array, "L"], state: T, *others: Any, turns: bool) -> T:
    """``function`` of ``state`` and ``others`` for every lane that is live; the rest keep their ``state``.

    Args:
      live: [L]. state, others: leading axis L.
      turns: one lane after another, instead of side by side.
    """
    if turns:
        return jax.lax.map(
            lambda lane: jax.lax.cond(lane[0], function, lambda same, *_: same, *lane[1:]),
            (live, state, *others),
        )
    moved = jax.vmap(function)(state, *others)
    return jax.vmap(partial(jax.tree.map, jnp.where), in_axes=(0, 0, 0))(_like(live, state), moved, state)


def _like(live: Bool[Array, "L"], state: T) -> T:
    return jax.tree.map(lambda _: live, state)


def make(config: Config, mesh: Mesh, turns: bool):
    """The compiled loop of all lanes, (states [L], live [L]) -> states; it donates the first."""
    train = device_loop.on_device(config, devices=1)
    lanes = PartitionSpec(AXIS)
    mapped = jax.shard_map(
        lambda states, live: each(train, live, states, turns=turns),
        mesh=mesh, in_specs=(lanes, lanes), out_specs=lanes, check_vma=False,
    )  # fmt: skip
    return jax.jit(mapped, donate_argnums=0)


class Lanes:
    """The states of all lanes, on their devices.

    Args:
      states: of each lane at its start, on any device; they are copied.
    """

    def __init__(self, config: Config, states: Sequence[TrainState], mesh: Mesh) -> None:
        together, self._mesh = filled(states, mesh), mesh
        self._per_device = len(together) // mesh.size
        split = NamedSharding(mesh, PartitionSpec(AXIS))
        self._states = jax.device_put(jax.tree.map(lambda *x: jnp.stack(x), *together), split)
        self._advance = make(config, mesh, one_by_one())

    def advance(self, live: Sequence[bool]) -> None:
        """A report's windows further, in the lanes that are live."""
        self._states = self._advance(self._states, flags(live, self._mesh))

    def take(self, lane: int) -> TrainState:
        """A copy of one lane's state, on its device."""
        device, place = divmod(lane, self._per_device)
        where = self._mesh.devices.flat[device]
        mine = jax.tree.map(
            lambda x: next(s.data for s in x.addressable_shards if s.device == where), self._states
        )
        return _pick(mine, place)

    def put(self, lane: int, state: TrainState) -> None:
        """Exchange one lane's state."""
        whole = NamedSharding(self._mesh, PartitionSpec())
        self._states = jax.jit(
            lambda states, one: jax.tree.map(lambda all, x: all.at[lane].set(x), states, one),
            out_shardings=NamedSharding(self._mesh, PartitionSpec(AXIS)),
        )(self._states, jax.device_put(state, whole))


@jax.jit
def _pick(states: TrainState, place: Array | int) -> TrainState:
    return jax.tree.map(itemgetter(place), states)


class LaneRunner(Runner):
    """As `Runner`, of one batch of trials for each lane: scenarios and trials are [N, L].

    Its ``run`` takes as ``params`` which of the lanes are live, [L], and the parameters of each, [L, ...];
    the trials of other lanes stay at their start.
    """

    def __init__(self, task: Task, act: Act, batch: int, mesh: Mesh, turns: bool) -> None:
        super().__init__(task, act, batch, devices.mesh(1), spread=lambda function, *_: function)
        begin, advance = self.begin, self.advance  # of one lane
        lanes, trials, same = PartitionSpec(AXIS), PartitionSpec(None, AXIS), PartitionSpec()

        def begin_all(numbers: Any, scenarios: Scenario) -> Trial:
            return _last(jax.lax.map(partial(begin, numbers), _first(scenarios)))

        def advance_all(params: Params, profile: Any, windows: Array, trials: Trial) -> Trial:
            def one(trials: Trial, params: Params) -> Trial:
                return advance(params, profile, windows, trials)

            live, own = params
            return _last(each(one, live, _first(trials), own, turns=turns))

        spread = partial(jax.shard_map, mesh=mesh, out_specs=trials, check_vma=False)
        self.begin = jax.jit(spread(begin_all, in_specs=(same, trials)))
        self.advance = jax.jit(spread(advance_all, in_specs=(lanes, same, same, trials)), donate_argnums=3)


def _first(trials: T) -> T:
    """[N, L, ...] as [L, N, ...]."""
    return jax.tree.map(lambda x: jnp.swapaxes(x, 0, 1), trials)


_last = _first  # and back
