"""Brax's PPO and SAC: what they learn is one of our policies, and nothing of Brax or JAX stays changed."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from brax.training import acting
from brax.training.acme import running_statistics
from brax.training.agents.ppo import networks as ppo_networks
from brax.training.agents.sac import networks as sac_networks

from jaxwalk import cli
from jaxwalk.config import Config, DDPGConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.brax import baselines
from jaxwalk.learn.brax.options import PPO, SAC, PPOArgs, SACArgs
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train import evaluation
from jaxwalk.task import rules

CONFIG = Config(ddpg=DDPGConfig(hidden=(16, 8)))
SIZE = len(CONFIG.observation)
ORIGIN = dict(seed=3, command="jaxwalk train-baseline", footsteps=7, score=0.5)
KINDS = {
    "ppo": (baselines._ppo_networks, ppo_networks.make_inference_fn),
    "sac": (baselines._sac_networks, sac_networks.make_inference_fn),
}


@pytest.fixture(params=KINDS)
def made(request):
    """Networks as Brax's trainer makes them, and a normaliser that has seen something."""
    make, inference = KINDS[request.param]
    networks = make(CONFIG, 0.25, SIZE, 2, preprocess_observations_fn=running_statistics.normalize)
    start = running_statistics.init_state(jax.ShapeDtypeStruct((SIZE,), jnp.float32))
    rows = jnp.arange(1.0, SIZE + 1) * (2.0 + jax.random.normal(jax.random.key(1), (50, SIZE)))
    return networks, inference(networks), running_statistics.update(start, rows)


def shaken(tree):
    """Every parameter moved, as training does."""
    leaves, structure = jax.tree.flatten(tree)
    keys = jax.random.split(jax.random.key(5), len(leaves))
    moved = [x + 0.3 * jax.random.normal(k, x.shape) for x, k in zip(leaves, keys, strict=True)]
    return jax.tree.unflatten(structure, moved)


def test_a_converted_policy_acts_as_brax_s_own(made, tmp_path):
    networks, make_policy, seen = made
    params = (seen, shaken(networks.policy_network.init(jax.random.key(2))))
    observations = seen.mean + 2.0 * seen.std * jax.random.normal(jax.random.key(3), (100, SIZE))
    theirs, _ = make_policy(params, deterministic=True)(observations, jax.random.key(0))
    ours = baselines.convert(CONFIG, params, **ORIGIN)
    policy.save(ours, tmp_path / "policy.safetensors")
    subject = named.load(str(tmp_path / "policy.safetensors"))
    assert np.abs(theirs).max() > 0.5, "no action is far from 0"
    np.testing.assert_allclose(policy.act(ours, observations), theirs, atol=1e-6)
    np.testing.assert_allclose(subject.act(subject.params, observations), theirs, atol=1e-6)


def test_the_first_policy_is_near_the_nominal_step_with_the_spread_asked_for(made):
    networks, make_policy, seen = made
    params = (seen, networks.policy_network.init(jax.random.key(2)))
    observations = jax.random.normal(jax.random.key(3), (200, SIZE)) * seen.std + seen.mean
    actions, _ = make_policy(params, deterministic=True)(observations, jax.random.key(0))
    np.testing.assert_allclose(actions, np.tile(rules.nominal(CONFIG), (200, 1)), atol=0.03)
    logits = networks.policy_network.apply(*params, observations)
    spread = networks.parametric_action_distribution.create_dist(logits).scale
    np.testing.assert_allclose(spread, 0.25, atol=0.02)


def test_brax_discounts_and_ends_in_the_same_time_however_often_steps_are_decided(monkeypatch):
    asked = []
    for trainer in (baselines.ppo, baselines.sac):
        monkeypatch.setattr(trainer, "train", lambda env, **told: asked.append(told))
    for config in (CONFIG, PRESETS["rigid"]):
        baselines._ppo(config, PPO(), 0, 1000, 4, lambda *_: None)
        baselines._sac(config, SAC(), 0, 1000, 4, lambda *_: None)
        often = baselines.decisions(config)
        window = config.train.window_ticks * config.physics.timestep
        for told in asked[-2:]:
            assert told["discounting"] ** often == pytest.approx(config.ddpg.gamma)
            assert told["num_timesteps"] == 1000 * often and told["episode_length"] == 64 * often
        if config.task.replan:  # half a minute, as of a walker that is asked once a step
            assert 25 < asked[-1]["episode_length"] * config.task.replan * window < 40
        else:
            assert often == 1


def test_nothing_stays_changed_even_after_an_error():
    evaluator, had = acting.Evaluator, hasattr(jax, "device_put_replicated")
    with pytest.raises(ZeroDivisionError), baselines.trainable():
        assert acting.Evaluator is not evaluator
        copies = jax.device_put_replicated({"a": 3.0, "b": jnp.arange(2)}, jax.local_devices())
        raise ZeroDivisionError
    assert acting.Evaluator is evaluator and hasattr(jax, "device_put_replicated") == had
    many = jax.local_device_count()
    assert copies["a"].tolist() == [3.0] * many and copies["b"].tolist() == [[0, 1]] * many
    assert len(copies["a"].addressable_shards) == many


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        ([], "no algorithm ''"),
        (["a3c"], "no algorithm 'a3c': give ppo or sac"),
        (["ppo", "--seed", "-1"], "--seed -1"),
        (["ppo", "--walkers", "100"], "--walkers 100: --batch-size times --minibatches, 128"),
        (["ppo", "--updates-per-footstep", "1"], "--updates-per-footstep"),
        (["sac", "--footsteps", "300"], "gather 4096 footsteps for it, which must be less"),
        (["sac", "--updates-per-footstep", "0.001"], "0.0078125 or more"),
        (["sac", "--learning-rate", "nan"], "--learning-rate nan"),
    ],
)
def test_bad_options_are_one_line(argv, said, capsys):
    assert cli.main(["train-baseline", *argv]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_a_run_folder_with_a_run_in_it_is_left_alone(tmp_path, capsys):
    (tmp_path / "config.json").write_text("precious")
    assert cli.main(["train-baseline", "ppo", "--run-dir", str(tmp_path)]) == 2
    assert "already holds a run" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["config.json"]


def test_help(capsys):
    assert cli.main(["train-baseline", "--help"]) == 0
    assert cli.main(["train-baseline", "sac", "--help"]) == 0
    assert "--updates-per-footstep" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_a_whole_run(algorithm, tmp_path, monkeypatch):
    monkeypatch.setattr(evaluation, "SECONDS", 2.0)
    monkeypatch.setattr(evaluation, "PHASES", 1)
    monkeypatch.setattr(evaluation, "CALM", 2)
    walkers = 4 * jax.local_device_count()
    common: dict[str, Any] = dict(run_dir=tmp_path / "run", seed=1, footsteps=4 * walkers, evaluations=2)
    if algorithm == "ppo":
        args = PPOArgs(
            settings=PPO(walkers=walkers, unroll_length=2, batch_size=walkers, minibatches=1, epochs=2),
            **common,
        )
    else:
        args = SACArgs(settings=SAC(walkers=walkers, warmup=walkers, batch_size=8), **common)
    folder = baselines.train(CONFIG, args, "jaxwalk train-baseline")

    summary = run_folder.read_summary(folder)
    rows = run_folder.read_metrics(folder)
    assert [row["footsteps"] for row in rows] == sorted(row["footsteps"] for row in rows) and len(rows) == 3
    assert summary["footsteps"] == rows[-1]["footsteps"] >= args.footsteps
    assert (summary["algorithm"], summary["interrupted"]) == (algorithm, False)
    kept = next(row for row in rows if row["footsteps"] == summary["best"]["footsteps"])
    assert summary["best"]["score"] == kept["eval/score"]
    assert summary["best"]["footsteps"] == max(summary["finals"], key=lambda one: one["score"])["footsteps"]
    best = policy.load(folder / "policy.safetensors")
    assert best.metadata.footsteps == summary["best"]["footsteps"]
    first = policy.load(folder / "checkpoints" / "000000000.safetensors")
    last = policy.load(folder / "checkpoints" / f"{summary['footsteps']:09d}.safetensors")
    assert any(
        bool((a != b).any())
        for a, b in zip(jax.tree.leaves(first.actor), jax.tree.leaves(last.actor), strict=True)
    ), "nothing was learned"
    named.load(str(folder))
