"""Weights files of tiny networks of joints, right ones and wrong ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from topview.detect.joints import PROPOSED_JOINTS

CHANNELS = 8


def write_network(
    path: Path,
    *,
    modes: int = 2,
    joints: tuple[str, ...] = PROPOSED_JOINTS,
    format: str = "topview joints 2",
    pixels: int = 128,
    constant: float = 0.0,
    nan_on_people: bool = False,
    places_of: int | None = None,
) -> Path:
    """Write a network of random weights, whose answers depend on all that a window shows.

    Args:
        path: of the file.
        modes, joints, format: as the file tells them, and as it answers.
        pixels: on each side of its windows.
        constant: is added to the places.
        nan_on_people: whether all that it says is NaN where the window shows somebody.
        places_of: how many joints it gives places for, if not for all.
    """
    rng = np.random.default_rng(4)
    J = len(joints)
    placed = J if places_of is None else places_of
    filters = rng.normal(0.0, 0.3, (CHANNELS, 3, 3, 3))
    sizes = {"places": modes * placed * 3, "log_scales": modes * J * 3, "mode_logits": modes}
    sizes["person_logit"] = 1
    shapes = {"places": [-1, modes, placed, 3], "log_scales": [-1, modes, J, 3]}
    shapes |= {"mode_logits": [-1, modes], "person_logit": [-1]}
    values: dict[str, np.ndarray] = {
        "filters": filters.astype(np.float32),
        "one": np.full((1, 3, 1, 1), 0.5, np.float32),
        "visible_shape": np.array([-1, 32, 32]),
        "own": np.array([1]),
    }
    nodes = [
        helper.make_node("Conv", ["windows", "filters"], ["c"], strides=[2, 2], pads=[1] * 4),
        helper.make_node("Relu", ["c"], ["r"]),
        helper.make_node("GlobalAveragePool", ["r"], ["g"]),
        helper.make_node("Flatten", ["g"], ["f"]),
        helper.make_node("AveragePool", ["windows"], ["a"], kernel_shape=[4, 4], strides=[4, 4]),
        helper.make_node("Conv", ["a", "one"], ["v"]),
        helper.make_node("Reshape", ["v", "visible_shape"], ["visible"]),
        helper.make_node("ReduceMax", ["windows"], ["most"], axes=[2, 3], keepdims=0),
        helper.make_node("Gather", ["most", "own"], ["somebody"], axis=1),
        helper.make_node("Neg", ["somebody"], ["minus"]),
        helper.make_node("Sqrt" if nan_on_people else "Identity", ["minus"], ["poison"]),
    ]
    for name, size in sizes.items():
        values[f"{name}_w"] = rng.normal(0.0, 0.2, (CHANNELS, size)).astype(np.float32)
        values[f"{name}_b"] = np.full(size, constant if name == "places" else 0.0, np.float32)
        values[f"{name}_s"] = np.array(shapes[name])
        gemm = ["f", f"{name}_w", f"{name}_b"]
        nodes += [
            helper.make_node("Gemm", gemm, [f"{name}_m"]),
            helper.make_node("Add", [f"{name}_m", "poison"], [f"{name}_p"]),
            helper.make_node("Reshape", [f"{name}_p", f"{name}_s"], [name]),
        ]
    model = helper.make_model(
        helper.make_graph(
            nodes,
            "joints",
            [helper.make_tensor_value_info("windows", TensorProto.FLOAT, ["P", 3, pixels, pixels])],
            [
                helper.make_tensor_value_info(name, TensorProto.FLOAT, None)
                for name in (*sizes, "visible")
            ],
            [numpy_helper.from_array(array, name) for name, array in values.items()],
        ),
        opset_imports=[helper.make_opsetid("", 17)],
        ir_version=8,
    )
    helper.set_model_props(model, {"format": format, "joint_names": ",".join(joints)})
    onnx.save(model, path)
    return path
