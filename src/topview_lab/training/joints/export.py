"""Writes a trained network as the weights that `topview.detect.joints.network` loads."""

from __future__ import annotations

import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
import onnx
import torch
from onnx import helper, numpy_helper

from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import INPUT, OUTPUTS, VISIBLE, WEIGHTS_FORMAT
from topview.detect.joints.windows import WINDOW_PIXELS
from topview_lab.training.joints.net import JointNet

HALF_PRECISION_FROM: Final = 64  # values; smaller arrays stay in single precision (ours)


def exported(net: JointNet) -> bytes:
    """The network as ONNX: batch normalisation folded in, weights in half precision."""
    example = torch.zeros(2, 3, WINDOW_PIXELS, WINDOW_PIXELS)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "joints.onnx"
        # The newer exporter needs two more packages, and does no better on so plain a network.
        with warnings.catch_warnings(action="ignore"):
            torch.onnx.export(
                net.eval(),
                (example,),
                path,
                input_names=[INPUT],
                output_names=[*OUTPUTS, VISIBLE],
                dynamic_axes={name: {0: "people"} for name in (INPUT, *OUTPUTS, VISIBLE)},
                opset_version=17,
                dynamo=False,
            )
        model = onnx.load(path)
    _halve(model)
    helper.set_model_props(
        model, {"format": WEIGHTS_FORMAT, "joint_names": ",".join(PROPOSED_JOINTS)}
    )
    onnx.checker.check_model(model)
    return model.SerializeToString()


def _halve(model: onnx.ModelProto) -> None:
    """Store weights in half precision; the first nodes make them single again, once, when the file
    is loaded."""
    casts = []
    for weights in model.graph.initializer:
        values = numpy_helper.to_array(weights)
        if values.dtype != np.float32 or values.size < HALF_PRECISION_FROM:
            continue
        name = weights.name
        weights.CopyFrom(numpy_helper.from_array(values.astype(np.float16), f"{name}_half"))
        casts.append(helper.make_node("Cast", [f"{name}_half"], [name], to=onnx.TensorProto.FLOAT))
    nodes = [*casts, *model.graph.node]
    del model.graph.node[:]
    model.graph.node.extend(nodes)
