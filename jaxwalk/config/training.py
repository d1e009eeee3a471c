"""Learning: the pushes that are met, the reward, the learner, the loop around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class TaskConfig:
    """What is decided, and when."""

    replan: int = 5
    """Decision windows after which the policy is asked again, until the foot lands; 0: at touch-down alone,
    as in the paper."""


@dataclass(frozen=True)
class PushConfig:
    """The pushes that walkers meet in training."""

    rate: float = 1.0
    """Mean number of pushes a second, of those who have rested (0: none)."""
    rest: float = 2.5
    """Time after a push, and after the start, before the next one may come, s, to a step: what came of a push
    is told from what comes of the next."""
    soon: float = 0.2
    """Share of the pushes that come without that rest, half a second to one and a half after the last, to a
    step."""
    impulse_forward: float = 170.0
    """Largest push from behind, N s."""
    impulse_backward: float = 165.0
    """Largest push from the front, N s."""
    impulse_least: float = 0.2
    """Smallest push, as a share of the largest of its direction."""
    focus: float = 0.7
    """Share of the pushes that are dealt by how open their outcome is, for each side, size and phase of the
    step, for walkers with late instruments and for those just pushed apart; the others are dealt alike."""
    duration: float = 0.1
    """How long the force lasts, s."""
    height_spread: float = 0.2
    """Pushes land within this distance of the torso's centre, m."""


@dataclass(frozen=True)
class RewardConfig:
    """The reward of one footstep: exp(-cost), cost a weighted sum of normalised squares."""

    speed_weight: float = 8.0
    """Weight of ((|v - v_desire| - tolerance) / 0.5 m/s)^2, where positive."""
    speed_tolerance: float = 0.025
    """How far the speed may be off at no cost, m/s: a little faster is a lot safer from the front."""
    pitch_weight: float = 0.5
    """Weight of (phi / 0.2 rad)^2."""
    zmp_weight: float = 0.0
    """Weight of (d_zmp / 0.3 m)^2; 0.1 in the preset ``paper``. It is told of the foot that has just landed,
    while the body is still over the other one, and so pays for short steps."""
    length_weight: float = 0.02
    """Weight of ((l - l_nominal) / 0.3 m)^2, l_nominal being Boulic's step at v_desire."""
    work_weight: float = 0.1
    """Weight of (c / 0.1)^2, c being the positive work of all joints over about a step, to weight and way at
    the speed desired, J/(N m): of joints moved by torques."""
    fall: float = -10.0
    """Added when the walker falls."""


@dataclass(frozen=True)
class DDPGConfig:
    """The learner. The preset ``paper`` holds Liu et al.'s values."""

    hidden: tuple[int, ...] = (64, 64)
    """Widths of the hidden layers of actor and critic (the paper's: 400 and 300)."""
    actor_lr: float = 2e-4
    """Learning rate of the actor."""
    critic_lr: float = 1e-3
    """Learning rate of the critic."""
    gamma: float = 0.8
    """Discount per footstep."""
    return_steps: int = 10
    """Decisions whose rewards a critic's target holds before it believes its own word (1: the paper's)."""
    tau: float = 0.02
    """Share of the online parameters that enters the targets at each update."""
    action_weight: float = 1.0
    """Price of the mean square of the actor's answers, in units of reward: where the critic tells no
    difference they stay near 0, the plan as it is."""
    average_rate: float = 5e-4
    """Share of the actor that enters the policy that is evaluated and kept, at each update (1: all)."""
    batch_size: int = 1_024
    """Transitions in one update."""
    replay_capacity: int = 1_048_576
    """Transitions that are remembered."""
    warmup: int = 15_000
    """Footsteps gathered before the first update."""
    start: Literal["nominal", "random"] = "nominal"
    """First answer of the actor: the nominal step (from the height-to-stride-length ratio, as in the paper),
    or one drawn from all that can be commanded."""
    critic_head_start: int = 1_500
    """Updates of the critic before the actor moves: an early critic would lead it astray."""
    updates_per_footstep: float = 0.04
    """Updates for each footstep gathered."""
    noise_start: float = 0.25
    """Standard deviation of the exploration noise at first, in units of half the action range."""
    noise_end: float = 0.15
    """The same at the end of training."""
    noise_seconds: float = 0.4
    """Time in which the exploration noise forgets itself, s: a step that is changed throughout tells more
    than one that is shaken (0: each answer's is its own)."""
    noise_spread: float = 4.0
    """Ratio of the noisiest to the quietest walker's exploration (1: all alike)."""
    privileged: bool = True
    """The critic is told besides of the body, what it bears, and the push that is to come; no policy is."""
    layer_norm: bool = True
    """LayerNorm after each hidden layer of the critic."""
    weight_decay: float = 1e-4
    """Decoupled weight decay of the critic."""
    max_grad_norm: float = 10.0
    """Gradients are clipped to this global norm (0: never)."""
    normalize_observations: bool = True
    """Sampled observations are centred and scaled by running statistics."""
    twin: bool = False
    """TD3: two critics, the smaller one believed, with delayed actor and smoothed targets."""
    policy_delay: int = 2
    """TD3: critic updates for each actor update."""
    target_noise: float = 0.2
    """TD3: standard deviation of the smoothing noise on the target action."""
    target_noise_clip: float = 0.5
    """TD3: largest smoothing noise."""


@dataclass(frozen=True)
class ESConfig:
    """The evolution strategy (``--learner es``): separable CMA-ES (Ros and Hansen 2008) over the network's
    numbers."""

    generations: int = 60
    """How often all candidates walk."""
    candidates: int = 40
    """Policies of a generation."""
    walkers: int = 128
    """Of each candidate."""
    seconds: float = 9.0
    """They walk for so long, s."""
    sigma: float = 0.1
    """First step size of the search, in units of the network's numbers."""


@dataclass(frozen=True)
class TrainConfig:
    """The training loop."""

    walkers: int = 1_024
    """Walkers that learn side by side."""
    footsteps: int = 500_000
    """Footsteps gathered before training ends."""
    window_ticks: int = 10
    """Ticks between two looks at whether a walker needs a decision."""
    episode_seconds: float = 30.0
    """A walker that still stands is started anew after this time (truncation)."""
    height_spread: float = 0.22
    """Statures are drawn uniformly within this share of the body's height."""
    mass_spread: float = 0.2
    """Masses (at given stature) are drawn uniformly within this share."""
    windows_per_report: int = 20
    """Windows between two lines of metrics; the loop runs on the device for so long."""
    evaluations: int = 16
    """Evaluations spread over training; the best ones' policies meet in the finals."""
    finalists: int = 3
    """How many meet there, under more pushes (1: none do, the best evaluation decides)."""
    checkpoint_seconds: float = 60.0
    """Least time between two checkpoints for ``--resume``; they are begun between reports, s (0: none)."""
    divergence_limit: int = 100
    """Updates skipped since the last evaluation, being not finite, beyond which training goes back to it."""
    divergence_events: int = 3
    """How many times training may come to that before the run stops."""
