"""Writes a trained network as the weights that `topview.detect.joints.network` loads.

Most convolutions work on whole numbers of 8 bits, which takes half the time. How large the numbers
become is told by windows of the training. What becomes largest in one of ten thousand places is
cut off, so that sums of two products stay within 16 bits also on a processor that adds them so.
The first and last convolutions, and all means under the heat maps, stay in single precision.
"""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import onnx
import torch
from onnx import helper
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)
from torch import Tensor

from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import INPUT, OUTPUTS, VISIBLE, WEIGHTS_FORMAT
from topview.detect.joints.windows import WINDOW_PIXELS
from topview_lab.training.joints.net import JointNet

LOOKED_AT: Final = 64  # windows (ours); twice as many take twice the memory and change little
CUT_OFF: Final = 99.99  # percent of all values are within (ours)
IN_SINGLE_PRECISION: Final = "stem", "heat", "features", "visible"
"""Layers of `JointNet`: what comes in spans the box in steps of millimetres, and what goes out are
places."""


def exported(net: JointNet, images: Tensor) -> bytes:
    """The network as ONNX, batch normalisation folded in.

    Args:
        net: that is trained.
        images: [B, 3, 128, 128] windows of the kind that it was shown.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "joints.onnx"
        _write(net, path)
        layers = [node.name for node in onnx.load(path).graph.node if node.op_type == "Conv"]
        with _silent():
            quantize_static(
                path,
                path,
                _Windows(images[:LOOKED_AT]),
                quant_format=QuantFormat.QDQ,
                op_types_to_quantize=["Conv"],
                nodes_to_exclude=[name for name in layers if _layer(name) in IN_SINGLE_PRECISION],
                per_channel=True,
                activation_type=QuantType.QUInt8,
                weight_type=QuantType.QInt8,
                calibrate_method=CalibrationMethod.Percentile,
                extra_options={"CalibPercentile": CUT_OFF},
            )
        model = onnx.load(path)
    helper.set_model_props(
        model, {"format": WEIGHTS_FORMAT, "joint_names": ",".join(PROPOSED_JOINTS)}
    )
    onnx.checker.check_model(model)
    return model.SerializeToString()


def _write(net: JointNet, path: Path) -> None:
    """In single precision."""
    example = torch.zeros(2, 3, WINDOW_PIXELS, WINDOW_PIXELS)
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


def _layer(node: str) -> str:
    """The layer of `JointNet` that a node is of: `up_16` of `/up_16/body/body.0/Conv`."""
    return node.split("/")[1]


class _Windows(CalibrationDataReader):
    """Gives the windows one by one, and then nothing."""

    def __init__(self, images: Tensor) -> None:
        self._left = iter(images.split(1))

    def get_next(self) -> dict[str, Any]:
        image = next(self._left, None)
        return {} if image is None else {INPUT: image.numpy()}


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """onnxruntime tells of its work by print and on the root logger."""
    logging.disable(logging.WARNING)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        logging.disable(logging.NOTSET)
