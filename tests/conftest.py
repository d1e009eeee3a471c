"""For all tests: signatures are checked, compiled programs are remembered."""

import gc
import os
import sys
from importlib import import_module, metadata
from pathlib import Path

# XLA's dearer passes take half of the tests' time and change nothing that they say; JAX's own CI does so too.
# Before JAX is imported; the processes that tests start inherit it.
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
# Nor do programs by XLA's older emitter, which compiles in less than half the time. Another XLA may not know
# the flag, and would not start.
_OLDER_EMITTER = "xla_cpu_use_fusion_emitters"
if metadata.version("jaxlib").startswith("0.10.") and _OLDER_EMITTER not in os.environ.get("XLA_FLAGS", ""):
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} --{_OLDER_EMITTER}=false".strip()

sys.path.append(str(Path(__file__).parent))
# Before any module of the package is imported: every call's types and shapes are checked.
import_module("typecheck").install()

import_module("jaxwalk.common.runtime").setup()


# Files that take longest, about in this order. Begun last, one of them would keep a single worker busy.
DEAREST = """
measure/bench/test_bench learn/train/test_resume task/test_backend model/test_physics deploy/test_deploy
kernels/test_fused learn/ddpg/test_probe task/test_replan measure/push_map/test_push_map task/test_collect
task/test_env measure/test_generalise measure/test_evaluate test_api docs/test_readme measure/test_walk
measure/gait/test_forces measure/gait/test_record learn/train/test_run learn/ddpg/test_update
measure/gait/test_gait_report control/test_walker measure/test_report kernels/test_native
learn/train/test_es learn/train/test_costs export/test_export model/test_burdens fuzz/test_files
control/rigid/test_back_step
""".split()


def pytest_collection_modifyitems(items):
    """The dearest files first; xdist hands them out in this order, given --no-loadscope-reorder."""
    place = {Path(__file__).parent / f"{name}.py": order for order, name in enumerate(DEAREST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


def pytest_collection_finish():
    """What is imported by then stays: to go over all of it at each collection costs minutes."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 50)
