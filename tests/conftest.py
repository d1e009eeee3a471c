"""For all tests: signatures are checked, compiled programs are remembered."""

import gc
import os
import sys
from importlib import import_module, metadata
from pathlib import Path

# XLA's dearer passes take a fifth of the tests' time and change nothing that they say; JAX's CI does so too.
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


# Files that take longest, about in this order. Begun last, one of them would keep a single worker
# busy; two that need one program (kernels/test_fused, task/test_backend) are not begun together.
DEAREST = """
learn/train/test_resume measure/bench/test_bench kernels/test_fused task/test_replan deploy/test_deploy
measure/push_map/test_push_map task/test_collect measure/test_generalise model/test_physics
task/test_backend fuzz/test_files measure/gait/test_record task/test_env measure/gait/test_forces
measure/test_report model/test_burdens measure/test_evaluate measure/gait/test_gait_report
learn/train/test_es control/rigid/test_back_step learn/ddpg/test_probe docs/test_readme show/test_render
learn/sweep/test_sweep show/test_view control/test_walker task/test_kept_walk model/test_newton
learn/train/test_costs export/test_export
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
