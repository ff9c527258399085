"""The joint network's last layer, which tells whether a window shows a person.

It sees 128 means over the window. They, and all that the network says of joints, stay as they were
learnt; the layer is fitted anew on the very windows that the tracker asks about, which it could not
have seen while the network was learnt.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints.network import INPUT, opened
from topview.records import InputError

Floats = NDArray[np.float32]
Vector = NDArray[np.float64]

MATRIX, BIAS = "whole.weight", "whole.bias"
"""Of the layer that tells modes, and last whether there is a person; as `net.JointNet` names it."""
WRITTEN_AS: Final = (MATRIX, f"{MATRIX}_half")


def means_under(weights: bytes) -> Callable[[Floats], Floats]:
    """What gives, of [P, 3, 128, 128] windows, the [P, C] means that the layer sees.

    Raises:
        InputError: weights that cannot be used.
    """
    import onnx  # extra `train`

    model = onnx.load_model_from_string(weights)
    name = _layer_of(model).input[0]
    model.graph.output.append(
        onnx.helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, None)
    )
    run = opened(model.SerializeToString()).run

    def means(images: Floats) -> Floats:
        one_by_one = [run([name], {INPUT: image[None]})[0] for image in images]
        return np.concatenate(one_by_one)

    return means


def layer_in(weights: bytes) -> tuple[float, Vector]:
    """Bias and [C] weights."""
    import onnx

    model = onnx.load_model_from_string(weights)
    values = {own.name: onnx.numpy_helper.to_array(own) for own in _values_of(model)}
    matrix = next(values[name] for name in WRITTEN_AS if name in values)
    return float(values[BIAS][-1]), matrix[-1].astype(np.float64)


def with_layer(weights: bytes, bias: float, layer: Vector) -> bytes:
    """The weights file with another bias and [C] weights, all else as it was."""
    import onnx

    model = onnx.load_model_from_string(weights)
    for own in _values_of(model):
        values = onnx.numpy_helper.to_array(own).copy()
        values[-1] = bias if own.name == BIAS else layer
        own.CopyFrom(onnx.numpy_helper.from_array(values, own.name))
    return model.SerializeToString()


def _layer_of(model: Any) -> Any:
    for node in model.graph.node:
        if MATRIX in node.input:
            return node
    raise InputError(f"weights have no {MATRIX}; they must come from `topview train-joints`")


def _values_of(model: Any) -> list[Any]:
    return [own for own in model.graph.initializer if own.name in (BIAS, *WRITTEN_AS)]
