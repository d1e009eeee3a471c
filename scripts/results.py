"""Measure everything in docs/results anew, one command after another; stop it and call it again to go on.

    python scripts/results.py    or make results; with --quick or QUICK=1 a rehearsal, in runs/results-quick

A result is current while jaxwalk/, models/ and its command are as docs/results/measured.json notes them. It
is made in runs/results-TREE and copied when it is whole; trainings stay there. Not in the list: what is of
another machine (gpu-*) or of other commits (batches.*, bench-changes.json, make-train.json).
"""

import json
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "docs" / "results"
SEEDS = (0, 1, 2)
PROGRAMS = {"jaxwalk": [sys.executable, "-m", "jaxwalk"], "python": [sys.executable]}
WORDS = {
    "pushes": "--replicas 64 --impulses -140,-125,-110,-95,-80,-60,-40,40,60,80,95,110,125,140,150",
    "hard": "--replicas 64 --impulses -95,-80,-65,-50,-40,40,60,80,95",
    "walls": "--walkers 64 --seconds 20 --impulses -40,30",
    "six": "--impulses -60,-45,-30,30,45,60",
    "legs": "torso+0.2,swing-thigh,swing-shank,stance-thigh,stance-shank",
    "one": "--timesteps 0.001 --iterations 4 --contact-timeconsts 0.004 --frictions 0.7",
    "tiny": "--footsteps 600 --warmup 128",
    "s": "--walkers 8 --seconds 5 --impulses -40,40 --phases 2 --replicas 2",
}
# File or folder | command | options in a rehearsal; what has a {seed} is a training, of each seed.
JOBS = """
evaluate/evaluate.json | jaxwalk evaluate shipped {pushes} --json {at} | {s}
fixed/evaluate.json | jaxwalk evaluate fixed {pushes} --json {at} | {s}
late/evaluate.json | jaxwalk evaluate shipped --delay 0.02 --motor-strength 0.8 {hard} --json {at} | {s}
twice/evaluate.json | jaxwalk evaluate shipped --push-again 1 {hard} --json {at} | {s}
push-map | jaxwalk push-map shipped --out {at} | --impulses -40,40 --phases 2 --replicas 2
push-map-points | jaxwalk push-map shipped --points {legs} {six} --out {at} | --phases 2 --replicas 1
walls/evaluate.json | jaxwalk evaluate shipped --model walls {walls} --json {at} | {s}
walls/trained-there.json | jaxwalk evaluate docs/paper/policies/walls-0.safetensors {walls} --json {at} | {s}
agreement | jaxwalk agreement shipped --out {at} | {s}
sensitivity | jaxwalk sensitivity shipped --out {at} | {s} {one}
generalise | jaxwalk generalise shipped --walkers 32 --beside replan --out {at} | {s} --only stature
policy.png | python scripts/draw_policy.py shipped --out {at} | --walkers 16 --seconds 5
gait | jaxwalk gait shipped --speeds 0.7,0.9,1.1,1.25 --out {at} | --walkers 4 --seconds 8
bench-cpu.json | jaxwalk bench --seconds 2 --json {at} | --walkers 16 --seconds 0.2
deploy/latency.json | jaxwalk bench --deploy shipped --json {at} | --seconds 0.2
deploy/walk.json | python scripts/deploy_walk.py --json {at} | --seconds 5 --walkers 1 --phases 1 --replicas 1
push-back-95.png | jaxwalk render shipped --push -95 --push-time 2.5 --seconds 6 --width 1920 --out {at} |
ddpg-{seed} | env JAX_NUM_CPU_DEVICES=1 jaxwalk train --seed {seed} --run-dir {at} | --preset smoke
quick-{seed} | jaxwalk train --preset quick --seed {seed} --run-dir {at} | --preset smoke
td3-{seed} | jaxwalk train --preset quick --ddpg.twin --seed {seed} --run-dir {at} | --preset smoke
sac-{seed} | jaxwalk train-baseline sac --footsteps 20000 --seed {seed} --run-dir {at} | {tiny}
es-{seed} | jaxwalk train --learner es --seed {seed} --run-dir {at} | --preset smoke --es.generations 2
ppo-{seed} | jaxwalk train-baseline ppo --footsteps 20000 --seed {seed} --run-dir {at} | --footsteps 1280
learning | python scripts/results.py --collect {runs} {at} |
rules | jaxwalk compare fixed constant raibert capture-point replan shipped --walkers 256 --seconds 60 \
--replicas 64 \
--impulses -125,-110,-95,-80,-60,40,70,95,125,140,145 --out {at} | {s}
compare | jaxwalk compare fixed constant raibert capture-point replan shipped {seeds} --walkers 64 \
--seconds 20 --impulses -100,-80,-60,-40,40,60,70,80 --out {at} | {s}
report.html | jaxwalk report shipped --results {results} --out {at} --parts \
compare evaluate push-map generalise sensitivity agreement gait |
"""


def jobs() -> list[tuple[str, str, str, bool]]:
    """(name, command, options of a rehearsal, whether it is a training), in order."""
    lines = [[part.strip() for part in line.split("|")] for line in JOBS.strip().splitlines()]
    return [
        (name.replace("{seed}", str(seed)), command.replace("{seed}", str(seed)), quick, "{seed}" in name)
        for name, command, quick in lines
        for seed in (SEEDS if "{seed}" in name else SEEDS[:1])
    ]


def collect(runs: Path, out: Path) -> None:
    """The evaluations of the trainings, without what else their metrics hold."""
    for run in sorted(path for name in ("ddpg", "sac", "ppo") for path in runs.glob(f"{name}-*")):
        rows = [x for x in (run / "metrics.jsonl").read_text().splitlines() if '"eval/survival"' in x]
        (out / run.name).mkdir(parents=True, exist_ok=True)
        (out / run.name / "metrics.jsonl").write_text("\n".join(rows) + "\n")


def main(argv: list[str]) -> int:
    """All jobs; the exit code of the first that fails."""
    if argv[:1] == ["--collect"]:
        collect(Path(argv[1]), Path(argv[2]))
        return 0
    quick, git = "--quick" in argv, ["git", "-C", str(ROOT)]
    trees = subprocess.check_output([*git, "rev-parse", "HEAD:jaxwalk", "HEAD:models"], text=True).split()
    tree = "".join(one[:8] for one in trees)
    if not quick and subprocess.check_output([*git, "status", "--porcelain", "jaxwalk", "models"]):
        sys.exit("results: jaxwalk/ or models/ differ from the last commit: commit them first")
    base = ROOT / "runs" / ("results-quick" if quick else f"results-{tree}")
    log = (base if quick else RESULTS) / "measured.json"
    measured = json.loads(log.read_text()) if log.is_file() else {}
    seeds = " ".join(
        f"{x}=" + ",".join(f"{base}/{x}-{seed}" for seed in SEEDS)
        for x in "ddpg quick td3 es sac ppo".split()
    )
    for name, command, small, training in jobs():
        at = base / name
        words = WORDS | {"at": at, "runs": base, "results": base if quick else RESULTS, "seeds": seeds}
        line = f"{command} {small if quick else ''}".format(**words).strip().replace(f"{ROOT}/", "")
        there = (at if training else log.parent / name).exists()
        if there and measured.get(name) == {"tree": tree, "command": line}:
            print(f"current: {name}", flush=True)
            continue
        if at.is_dir() and (training or name in measured):  # one that was stopped; one of other code
            shutil.rmtree(at)
        at.parent.mkdir(parents=True, exist_ok=True)
        print(f"{time.strftime('%H:%M:%S')} {line}", flush=True)
        argv = [part for word in shlex.split(line) for part in PROGRAMS.get(word, [word])]
        if code := subprocess.run(argv, cwd=ROOT, check=False).returncode:
            return code
        if not training and not quick:
            for file in [at] if at.is_file() else [x for x in at.rglob("[!.]*.*") if x.suffix != ".npz"]:
                (RESULTS / file.relative_to(base)).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, RESULTS / file.relative_to(base))
        measured[name] = {"tree": tree, "command": line}
        log.write_text(json.dumps(measured, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
