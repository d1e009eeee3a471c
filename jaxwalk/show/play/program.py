"""What a page's walker is made of: its start, its ticks and its decisions, as functions of plain memory.

They are the simulation's own, unrolled (`jaxwalk.kernels.portable`). All numbers of body, controllers and
policy are data, so that one program serves everyone whose task is of one kind.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from jaxwalk.config import Config, GaitConfig
from jaxwalk.config.gait import SWITCHES
from jaxwalk.kernels import portable
from jaxwalk.kernels.portable import Function, Place
from jaxwalk.model.burdens import Burden
from jaxwalk.task import scenarios, stepper
from jaxwalk.task.stepper import Stepper, Task

_WINDOW = """
// Layers of Flax's Dense, ReLU between them and tanh at the end; or, of no layers, always the same answer.
// net: layers; where there are any, then sizes, limit, mean, deviation, and of each layer kernel [in, out]
// and bias; else the answer.
static float room[2][%(widest)d];

static const float *answered(const float *net, const float *seen) {
  const int layers = (int)net[0];
  if (layers == 0) return net + 1;
  const float *sizes = net + 1, limit = sizes[layers + 1], *mean = sizes + layers + 2;
  int n = (int)sizes[0];
  const float *deviation = mean + n, *at = deviation + n;
  for (int i = 0; i < n; i++) {
    float x = (seen[i] - mean[i]) / deviation[i];
    room[0][i] = x > limit ? limit : x < -limit ? -limit : x;
  }
  for (int layer = 0; layer < layers; layer++) {
    const int m = (int)sizes[layer + 1];
    const float *from = room[layer & 1];
    float *to = room[1 - (layer & 1)];
    for (int j = 0; j < m; j++) {
      float sum = at[n * m + j];
      for (int i = 0; i < n; i++) sum += from[i] * at[i * m + j];
      if (layer + 1 < layers) {
        to[j] = sum > 0 ? sum : 0;
      } else {
        const float shrunk = exponential(-2.0f * magnitude(sum));
        to[j] = with_sign((1.0f - shrunk) / (1.0f + shrunk), sum);
      }
    }
    at += (n + 1) * m;
    n = m;
  }
  return room[layers & 1];
}

// One decision window: whoever asks is answered, and walks on.
extern "C" __attribute__((export_name("window"))) void window(F *state, const float *net) {
  if (bits<I>(state[%(asked)d])) {
    const float *told = answered(net, state + %(observation)d);
    F action[2] = {told[0], told[1]};
    answer(state, action);
  }
  for (int k = 0; k < %(ticks)d; k++) tick(state);
}
"""
WIDEST = 1024
"""Units that a network's layer may have."""


def functions(task: Task, gait: GaitConfig) -> tuple[Function, ...]:
    """Of one walker of ``task`` whose controllers have numbers of ``gait``'s kind."""
    given, state = shapes(task, gait)
    action = jax.ShapeDtypeStruct((2,), jnp.float32)
    return (
        Function("start", partial(_start, task), (state, given), fresh=True),
        Function("tick", partial(_tick, task), (state,)),
        Function("answer", stepper.decide, (state, action)),
    )


def source(config: Config) -> str:
    """The C++ of a walker of ``config``'s kind."""
    task = task_of(config)
    made = functions(task, config.gait)
    at = portable.layout(made[0].given[0])
    places = {"asked": at["asked"].at, "observation": at["observation"].at}
    window = _WINDOW % {"widest": WIDEST, "ticks": task.setup.window_ticks, **places}
    return portable.source(made) + window


def layouts(config: Config) -> tuple[dict[str, Place], dict[str, Place]]:
    """Where the numbers lie of what a start is given, and of a walker."""
    given, state = shapes(task_of(config), config.gait)
    return portable.layout(given), portable.layout(state)


def task_of(config: Config) -> Task:
    """What `source` depends on of a configuration, beside the kind of its controllers."""
    return Task.of(config).endless()


def kind(config: Config) -> dict[str, Any]:
    """All that a program of ``config`` fixes, by the configuration's own names."""
    task = task_of(config)
    fixed = {"observation": task.observation, "task.replan": task.replan}
    fixed |= {f"gait.{name}": getattr(config.gait, name) for name in SWITCHES}
    setup = task.setup
    fixed |= _told("body", setup.body, ("height", "mass")) | _told("physics", setup.physics, ("friction",))
    fixed |= _told("sensors", setup.sensors, ("noise",)) | {"train.window_ticks": setup.window_ticks}
    return json.loads(json.dumps(fixed))


def _told(name: str, part: Any, left_out: tuple[str, ...]) -> dict[str, Any]:
    return {f"{name}.{key}": x for key, x in dataclasses.asdict(part).items() if key not in left_out}


def digest(text: str) -> str:
    """Of a source, by which a module tells what it was made from."""
    return hashlib.sha256(text.encode()).hexdigest()


def shapes(task: Task, gait: GaitConfig) -> tuple[Any, Any]:
    """Shapes and types of what a start is given, and of the walker that it makes."""
    number = jax.ShapeDtypeStruct((), jnp.float32)
    given = {
        "numbers": jax.tree.map(lambda _: number, gait),
        "height": number,
        "mass": number,
        "noise": number,
        "seed": jax.ShapeDtypeStruct((), jnp.uint32),
        "burden": Burden(**{field.name: number for field in dataclasses.fields(Burden)}),
    }
    return given, jax.eval_shape(partial(_start, task), given)


def _start(task: Task, given: dict[str, Any]) -> Stepper:
    body = given["height"], given["mass"], given["noise"]
    words = jnp.stack([jnp.uint32(0), given["seed"]])  # of jax.random.key(seed)
    key = jax.random.fold_in(jax.random.wrap_key_data(words), scenarios.RECORDED)
    return stepper.start(task, given["numbers"], *body, key, given["burden"])


def _tick(task: Task, state: Stepper) -> Stepper:
    return stepper.alone(task, state)[0]
