"""The policy as ONNX: float32, any batch, standard operators only."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.deploy.file import MANIFEST
from jaxwalk.export import manifest
from jaxwalk.learn.policies import policy

_OPSET, _IR = 13, 7  # of 2020: old runtimes read it too, as on a Jetson


def to_onnx(trained: policy.Policy, told: dict[str, Any]) -> bytes:
    """``observation`` [batch, O] to ``action`` [batch, A] in [-1, 1] and ``command`` [batch, A], m and s.

    Raises:
      UserError: the package ``onnx`` is not there.
    """
    onnx = require("onnx")
    helper, numpy_helper = onnx.helper, onnx.numpy_helper
    low, high = (np.array([one[end] for one in told["action"]], np.float32) for end in ("low", "high"))
    held = {
        "mean": trained.observation_mean,
        "std": trained.observation_std,
        "low": low,
        "half_range": np.float32(0.5) * (high - low),
        "one": np.ones((), np.float32),
    }
    nodes = [
        helper.make_node("Sub", ["observation", "mean"], ["centred"]),
        helper.make_node("Div", ["centred", "std"], ["scaled"]),
    ]
    last = "scaled"
    if told["observation_clip"] is not None:
        held |= {
            "clip_low": np.float32(-told["observation_clip"]),
            "clip": np.float32(told["observation_clip"]),
        }
        nodes.append(helper.make_node("Clip", [last, "clip_low", "clip"], ["normalised"]))
        last = "normalised"
    for layer in [*(f"hidden_{i}" for i in range(len(told["hidden"]))), "output"]:
        held |= {f"{layer}_{leaf}": x for leaf, x in trained.actor[layer].items()}
        nodes.append(helper.make_node("Gemm", [last, f"{layer}_kernel", f"{layer}_bias"], [f"{layer}_sum"]))
        kind, last = ("Tanh", "action") if layer == "output" else ("Relu", layer)
        nodes.append(helper.make_node(kind, [f"{layer}_sum"], [last]))
    nodes += [
        helper.make_node("Add", ["action", "one"], ["raised"]),
        helper.make_node("Mul", ["raised", "half_range"], ["above_low"]),
        helper.make_node("Add", ["above_low", "low"], ["command"]),
    ]

    def value(name: str, ones: list[dict[str, Any]]) -> Any:
        doc = ", ".join(f"{one['name']} [{one['unit']}]" for one in ones)
        shape = ["batch", len(ones)]
        return helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, shape, doc_string=doc)

    graph = helper.make_graph(
        nodes,
        "jaxwalk_policy",
        [value("observation", told["observation"])],
        [value("action", told["action"]), value("command", told["action"])],
        [numpy_helper.from_array(np.asarray(x, np.float32), name) for name, x in held.items()],
    )
    opset = [helper.make_opsetid("", _OPSET)]
    model = helper.make_model(graph, opset_imports=opset, ir_version=_IR, producer_name="jaxwalk")
    model.producer_version = told["jaxwalk_version"]
    helper.set_model_props(model, {MANIFEST: manifest.text(told)})
    onnx.checker.check_model(model, full_check=True)
    return model.SerializeToString()


def require(name: str) -> Any:
    """The module ``name`` of the extra ``export``.

    Raises:
      UserError: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise UserError(f"--format onnx needs the package {name}: pip install 'jaxwalk[export]'") from None
