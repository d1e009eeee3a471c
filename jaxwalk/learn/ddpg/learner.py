"""DDPG (Lillicrap et al. 2015) and, by ``config.twin``, TD3 (Fujimoto et al. 2018).

All functions are pure and take the configuration first; it is hashable, so that callers
make it a static argument of ``jax.jit`` or bind it with ``functools.partial``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import jax
import jax.numpy as jnp
import optax
from jax import lax
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Key, PRNGKeyArray

from jaxwalk.config import DDPGConfig
from jaxwalk.learn.ddpg import networks, normalizer
from jaxwalk.learn.ddpg.networks import Params
from jaxwalk.learn.ddpg.normalizer import Normalizer
from jaxwalk.task.transition import Leaf, Transition


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Metrics:
    """Scalars of the latest update that was not skipped (all [], in units of reward).

    Attributes:
      critic_loss: mean squared error of the value, summed over critics; reward squared.
      actor_loss: minus the mean value of the actor's own actions, and the price of these. TD3 holds this and
        the next over while the actor waits.
      grad_norm_actor: before clipping.
      grad_norm_critic: before clipping.
      q_mean: mean value of the sampled actions.
      target_mean: mean of the value that is aimed at.
      skipped: updates skipped so far because a loss, gradient or parameter was not finite.
    """

    critic_loss: Leaf
    actor_loss: Leaf
    grad_norm_actor: Leaf
    grad_norm_critic: Leaf
    q_mean: Leaf
    target_mean: Leaf
    skipped: Leaf


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class LearnerState:
    """Everything that changes while learning.

    Attributes:
      actor, critic: online parameters; the critic's have a leading axis of 1 (TD3: 2).
      target_actor, target_critic: their slow followers.
      average: the actor, averaged over thousands of updates; what is evaluated and kept.
      actor_optimizer, critic_optimizer: state of Adam.
      normalizer: statistics of the observations.
      updates: [], updates made (skipped ones do not count).
      metrics: of the latest update.
    """

    actor: Params
    critic: Params
    target_actor: Params
    target_critic: Params
    average: Params
    actor_optimizer: Any
    critic_optimizer: Any
    normalizer: Normalizer
    updates: Leaf
    metrics: Metrics


def init(
    config: DDPGConfig,
    key: PRNGKeyArray,
    observation_size: int,
    initial_action: Sequence[float],
    privileged: int = 0,
) -> LearnerState:
    """A learner whose actor answers close to ``initial_action`` (A numbers) everywhere.

    Its observations go on with as many numbers as are ``privileged``, of which the actor is not told.

    With ``config.start`` random it answers close to one that ``key`` draws instead.

    Compiled (all but ``key`` static) it takes a fraction of the time.

    Raises:
      ValueError: an initial action that is not strictly between -1 and 1.
    """
    actor_key, critic_key = jax.random.split(key)
    actor = networks.init_actor(config.hidden, actor_key, observation_size, initial_action)
    if config.start == "random":
        actor = networks.random_start(actor, jax.random.fold_in(actor_key, 1))
    inputs = jnp.zeros((observation_size + privileged,)), jnp.zeros((len(initial_action),))
    ensemble = networks.critics(config.hidden, config.layer_norm, members=2 if config.twin else 1)
    critic = cast(Params, ensemble.init(critic_key, *inputs)["params"])
    return LearnerState(
        actor=actor,
        critic=critic,
        # Copies: no two leaves may share a buffer if the state is to be donated.
        target_actor=jax.tree.map(jnp.copy, actor),
        target_critic=jax.tree.map(jnp.copy, critic),
        average=jax.tree.map(jnp.copy, actor),
        actor_optimizer=_optimizer(config, config.actor_lr).init(actor),
        critic_optimizer=_optimizer(config, config.critic_lr, config.weight_decay).init(critic),
        normalizer=normalizer.init(observation_size + privileged, config.normalize_observations),
        updates=jnp.int32(0),
        metrics=Metrics(*(jnp.zeros(()) for _ in range(6)), skipped=jnp.int32(0)),
    )


def observe(
    state: LearnerState,
    observation: Float[Array, "B O"],
    mask: Bool[Array, " B"],
    axis_name: str | None = None,
) -> LearnerState:
    """Let the running statistics see raw observations; arguments as in ``normalizer.update``."""
    return replace(state, normalizer=normalizer.update(state.normalizer, observation, mask, axis_name))


def act(config: DDPGConfig, state: LearnerState, observation: Float[Array, "*B O"]) -> Float[Array, "*B A"]:
    """The actor's action in [-1, 1] for raw observations, with what is privileged or without, and without
    exploration."""
    return _act(config, state.actor, normalizer.normalize(state.normalizer, observation))


def averaged(state: LearnerState) -> LearnerState:
    """The learner with its averaged actor in the actor's place: gait quality swings less."""
    return replace(state, actor=state.average)


def value(
    config: DDPGConfig, state: LearnerState, observation: Float[Array, "B O"], action: Float[Array, "B A"]
) -> Float[Array, " B"]:
    """What the critic (TD3: the more doubtful of the two) expects to earn from here on."""
    normal = normalizer.normalize(state.normalizer, observation)
    return jnp.min(_values(config, state.critic, normal, action), axis=0)


def update(
    config: DDPGConfig,
    state: LearnerState,
    batch: Transition,
    keys: Key[Array, " B"],
    axis_name: str | None = None,
) -> tuple[LearnerState, Metrics]:
    """One step of the critic and, in DDPG or when its turn has come in TD3, of actor and targets.

    Args:
      config: static.
      state: the learner.
      batch: raw transitions [B].
      keys: [B], of the noise on TD3's target actions; DDPG ignores them.
      axis_name: an axis of shard_map whose members hold equal states, and different
        batches and keys. Gradients and metrics are averaged over it, so states stay equal.

    Returns:
      The new state and its metrics. If a loss, a gradient or a new parameter is not finite, the state
      is the old one, but for one more in ``metrics.skipped``.
    """
    batch = replace(
        batch,
        observation=normalizer.normalize(state.normalizer, batch.observation),
        next_observation=normalizer.normalize(state.normalizer, batch.next_observation),
    )
    new = _improve_critic(config, state, batch, keys, axis_name)
    new = replace(new, updates=state.updates + 1)
    if config.twin:
        new = lax.cond(
            new.updates % config.policy_delay == 0,
            lambda s: _improve_actor(config, s, batch, axis_name),
            lambda s: s,
            new,
        )
    else:
        new = _improve_actor(config, new, batch, axis_name)

    checked = jax.tree.leaves((new.metrics, new.actor, new.critic))
    finite = jnp.all(jnp.stack([jnp.all(jnp.isfinite(x)) for x in checked]))
    skipped = replace(state, metrics=replace(state.metrics, skipped=state.metrics.skipped + 1))
    new = jax.tree.map(lambda yes, no: jnp.where(finite, yes, no), new, skipped)
    return new, new.metrics


def _improve_critic(
    config: DDPGConfig, state: LearnerState, batch: Transition, keys: Key[Array, " B"], axis_name: str | None
) -> LearnerState:
    target = _target(config, state, batch, keys)

    def loss(critic: Params) -> tuple[Array, Array]:
        values = _values(config, critic, batch.observation, batch.action)
        return jnp.sum(jnp.mean(jnp.square(values - target[None]), axis=1)), jnp.mean(values)

    optimizer = _optimizer(config, config.critic_lr, config.weight_decay)
    critic, optimizer_state, (value, q_mean), norm = _descend(
        optimizer, loss, state.critic, state.critic_optimizer, axis_name
    )
    metrics = replace(
        state.metrics,
        critic_loss=value,
        grad_norm_critic=norm,
        q_mean=q_mean,
        target_mean=_mean(jnp.mean(target), axis_name),
    )
    return replace(state, critic=critic, critic_optimizer=optimizer_state, metrics=metrics)


def _improve_actor(
    config: DDPGConfig, state: LearnerState, batch: Transition, axis_name: str | None
) -> LearnerState:
    first = jax.tree.map(lambda x: x[:1], state.critic)

    def loss(actor: Params) -> tuple[Array, None]:
        action = _act(config, actor, batch.observation)
        value = jnp.mean(_values(config, first, batch.observation, action))
        return config.action_weight * jnp.mean(jnp.square(action)) - value, None

    actor, optimizer_state, (value, _), norm = _descend(
        _optimizer(config, config.actor_lr), loss, state.actor, state.actor_optimizer, axis_name
    )
    moving = state.updates > config.critic_head_start
    actor, optimizer_state = jax.tree.map(
        lambda new, old: jnp.where(moving, new, old),
        (actor, optimizer_state),
        (state.actor, state.actor_optimizer),
    )
    return replace(
        state,
        actor=actor,
        actor_optimizer=optimizer_state,
        target_actor=optax.incremental_update(actor, state.target_actor, config.tau),
        target_critic=optax.incremental_update(state.critic, state.target_critic, config.tau),
        average=optax.incremental_update(actor, state.average, config.average_rate),
        metrics=replace(state.metrics, actor_loss=value, grad_norm_actor=norm),
    )


def _target(config: DDPGConfig, state: LearnerState, batch: Transition, keys: Key[Array, " B"]) -> Array:
    """What the critic aims at [B]: reward + discount x the (smallest) target critic's value."""
    action = _act(config, state.target_actor, batch.next_observation)
    if config.twin:  # target policy smoothing: Fujimoto et al. 2018, eq. 14
        noise = config.target_noise * jax.vmap(lambda key: jax.random.normal(key, action.shape[1:]))(keys)
        noise = jnp.clip(noise, -config.target_noise_clip, config.target_noise_clip)
        action = jnp.clip(action + noise, -1.0, 1.0)
    values = _values(config, state.target_critic, batch.next_observation, action)
    return batch.reward + batch.discount * jnp.min(values, axis=0)


def _act(config: DDPGConfig, actor: Params, observation: Array) -> Array:
    action_size = actor["output"]["bias"].shape[0]
    told = actor["hidden_0" if config.hidden else "output"]["kernel"].shape[0]
    return networks.applied(networks.Actor(config.hidden, action_size), actor, observation[..., :told])


def _values(config: DDPGConfig, critic: Params, observation: Array, action: Array) -> Array:
    """Values [members, B]; how many members, the parameters' leading axis tells."""
    # One by one: XLA's CPU multiplies many matrices in one call at half the speed.
    one, members = networks.Critic(config.hidden, config.layer_norm), critic["output"]["bias"].shape[0]
    each = (jax.tree.map(lambda x, i=i: x[i], critic) for i in range(members))
    return jnp.stack([networks.applied(one, params, observation, action) for params in each])


def _optimizer(
    config: DDPGConfig, learning_rate: float, weight_decay: float = 0.0
) -> optax.GradientTransformation:
    """Adam behind a clip of the gradient's norm; decay spares biases and LayerNorm."""
    clip = optax.clip_by_global_norm(config.max_grad_norm) if config.max_grad_norm > 0 else optax.identity()
    return optax.chain(clip, optax.adamw(learning_rate, weight_decay=weight_decay, mask=_kernels))


def _kernels(params: Params) -> Any:
    return jax.tree_util.tree_map_with_path(lambda path, _: path[-1].key == "kernel", params)


def _descend(
    optimizer: optax.GradientTransformation,
    loss: Callable[[Params], tuple[Array, Any]],
    params: Params,
    optimizer_state: Any,
    axis_name: str | None,
) -> tuple[Params, Any, tuple[Array, Any], Array]:
    """One step down ``loss``: parameters, optimizer state, (loss, auxiliary), gradient norm."""
    # Each member's own gradient, also where JAX would sum that of replicated parameters over the axis.
    own = params if axis_name is None else lax.pcast(params, axis_name, to="varying")
    value, gradient = _mean(jax.value_and_grad(loss, has_aux=True)(own), axis_name)
    with jax.numpy_dtype_promotion("standard"):  # Adam's bias correction mixes int32 and float
        updates, optimizer_state = optimizer.update(gradient, optimizer_state, params)
    moved = cast(Params, optax.apply_updates(params, updates))  # of the form of what it was given
    return moved, optimizer_state, value, optax.tree.norm(gradient)


def _mean(tree: Any, axis_name: str | None) -> Any:
    """The mean over the axis as one message: devices that wait for each other cost more than numbers."""
    if axis_name is None:
        return tree
    flat, unflatten = ravel_pytree(tree)
    return unflatten(lax.pmean(flat, axis_name))
