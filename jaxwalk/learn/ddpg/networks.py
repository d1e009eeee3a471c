"""Actor and critic: multilayer perceptrons with ReLU (Lillicrap et al. 2015, sec. 7).

Within, a batch lies along the last axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

Params = dict[str, Any]  # nested: {layer: {"kernel": [in, out], "bias": [out], ...}}

_RANDOM_BOUND = 0.95  # largest action of a random start: at 1 tanh would not learn any more
_OUTPUT_BOUND = 3e-3  # half-width of the uniform start of output layers (Lillicrap)
# Uniform within 1 / sqrt(fan-in), Lillicrap's start of hidden layers.
_hidden_init = nn.initializers.variance_scaling(1.0 / 3.0, "fan_in", "uniform")


def _output_init(key: PRNGKeyArray, shape: Sequence[int], dtype: Any = jnp.float32) -> Array:
    return jax.random.uniform(key, shape, dtype, -_OUTPUT_BOUND, _OUTPUT_BOUND)


class Dense(nn.Module):
    """A linear layer of columns.

    Attributes:
      features: numbers that come out for each column.
      kernel_init: of the kernel [in, features].
    """

    features: int
    kernel_init: Any

    @nn.compact
    def __call__(self, x: Float[Array, "I N"]) -> Float[Array, "F N"]:
        """Columns [in, N] to columns [features, N]."""
        kernel = self.param("kernel", self.kernel_init, (x.shape[0], self.features))
        bias = self.param("bias", nn.initializers.zeros, (self.features,))
        return kernel.T @ x + bias[:, None]


class LayerNorm(nn.Module):
    """LayerNorm (Ba et al. 2016) of columns."""

    @nn.compact
    def __call__(self, x: Float[Array, "F N"]) -> Float[Array, "F N"]:
        """Each column brought to mean 0 and variance 1, then scaled and shifted row by row."""
        scale = self.param("scale", nn.initializers.ones, x.shape[:1])
        bias = self.param("bias", nn.initializers.zeros, x.shape[:1])
        mean = jnp.mean(x, axis=0)
        variance = jnp.maximum(jnp.mean(jnp.square(x), axis=0) - jnp.square(mean), 0.0)
        return (x - mean[None]) * jax.lax.rsqrt(variance + 1e-6)[None] * scale[:, None] + bias[:, None]


class Actor(nn.Module):
    """Deterministic policy: normalised observation [..., O] to action [..., A] in [-1, 1].

    Attributes:
      hidden: widths of the hidden layers.
      action_size: A.
    """

    hidden: tuple[int, ...]
    action_size: int

    @nn.compact
    def __call__(self, observation: Float[Array, "*B O"]) -> Float[Array, "*B A"]:
        """The actions for normalised observations."""
        x = _columns(observation)
        for i, width in enumerate(self.hidden):
            x = nn.relu(Dense(width, _hidden_init, name=f"hidden_{i}")(x))
        x = jnp.tanh(Dense(self.action_size, _output_init, name="output")(x))
        return x.T.reshape(*observation.shape[:-1], self.action_size)


class Critic(nn.Module):
    """Action value: normalised observation [..., O] and action [..., A] to [...].

    The action enters with the observation, as in TD3; Lillicrap feeds it to the second layer.

    Attributes:
      hidden: widths of the hidden layers.
      layer_norm: LayerNorm between each hidden layer and its ReLU.
    """

    hidden: tuple[int, ...]
    layer_norm: bool

    @nn.compact
    def __call__(self, observation: Float[Array, "*B O"], action: Float[Array, "*B A"]) -> Float[Array, "*B"]:
        """The values of actions at normalised observations."""
        x = jnp.concatenate([_columns(observation), _columns(action)])
        for i, width in enumerate(self.hidden):
            x = Dense(width, _hidden_init, name=f"hidden_{i}")(x)
            if self.layer_norm:
                x = LayerNorm(name=f"norm_{i}")(x)
            x = nn.relu(x)
        return Dense(1, _output_init, name="output")(x).reshape(observation.shape[:-1])


def _columns(x: Float[Array, "*B N"]) -> Float[Array, "N M"]:
    """The rows of a batch as columns: so a core's vector units go along the batch, LayerNorm's sums included,
    and an update takes half the time."""
    return x.reshape(-1, x.shape[-1]).T


def applied(network: nn.Module, params: Params, *inputs: Array) -> Any:
    """What ``network`` makes of ``inputs``: one array, for it has no variables that change."""
    return network.apply({"params": params}, *inputs)


def critics(hidden: tuple[int, ...], layer_norm: bool, members: int) -> nn.Module:
    """``members`` independent critics of the same input; values are [members, ...].

    Every parameter has a leading axis of that length, so that DDPG (1) and TD3 (2) share code.
    """
    ensemble = nn.vmap(
        Critic,
        variable_axes={"params": 0},
        split_rngs={"params": True},
        in_axes=None,  # pyright: ignore[reportArgumentType]  # flax's default hides that it may be None
        out_axes=0,
        axis_size=members,
    )
    return ensemble(hidden, layer_norm)


def init_actor(
    hidden: tuple[int, ...], key: PRNGKeyArray, observation_size: int, initial_action: Sequence[float]
) -> Params:
    """Parameters of an actor whose output starts close to ``initial_action`` everywhere.

    Raises:
      ValueError: an initial action that is not strictly between -1 and 1.
    """
    if not all(-1.0 < a < 1.0 for a in initial_action):
        raise ValueError(f"initial action {tuple(initial_action)}: tanh reaches only (-1, 1)")
    actor = Actor(hidden, len(initial_action))
    params = actor.init(key, jnp.zeros((observation_size,)))["params"]
    bias = jnp.arctanh(jnp.asarray(initial_action, jnp.float32))
    return {**params, "output": {**params["output"], "bias": bias}}


def random_start(params: Params, key: PRNGKeyArray) -> Params:
    """An actor's parameters, but that its output starts close to an action drawn uniformly from the range."""
    bias = params["output"]["bias"]
    action = jax.random.uniform(key, bias.shape, bias.dtype, -_RANDOM_BOUND, _RANDOM_BOUND)
    return {**params, "output": {**params["output"], "bias": jnp.arctanh(action)}}
