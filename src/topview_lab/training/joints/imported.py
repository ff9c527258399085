"""Reads weights that `topview.detect.joints.network` loads, so that a training goes on from them.

What ships has no batch normalisation left: it is part of the convolutions. Each gets one again that
changes nothing, told by windows of the training itself, as a training normalises by what it sees.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import numpy_helper
from torch import Tensor, nn

from topview.detect.joints.windows import WINDOW_PIXELS
from topview.records import InputError
from topview_lab.training.joints.net import JointNet, NetSettings

Weights = dict[str, NDArray[np.float32]]

_FIRST_AT = 0, 1, 6, 11  # of the convolutions: the first at 64, 32, 16 and 8 pixels a side


def imported(path: Path, images: Tensor) -> JointNet:
    """The network of weights that `exported` wrote.

    Args:
        path: the .onnx.
        images: [B, 3, 128, 128] windows of the kind that the training will show.

    Raises:
        InputError: the file cannot be read, or is of another network.
    """
    try:
        model = onnx.load(path)
        weights, convolutions = _weights(model), _convolutions(model)
        net = JointNet(_settings(weights, convolutions))
        _fill(net, weights, convolutions)
    except (OSError, ValueError, KeyError, IndexError, RuntimeError, AssertionError) as error:
        raise InputError(f"{path}: no weights of `topview train-joints` ({error})") from None
    except Exception as error:  # of protobuf, which has errors of its own
        raise InputError(f"{path} is no .onnx that can be read ({error})") from None
    _normalise(net, images)
    return net


def _weights(model: onnx.ModelProto) -> Weights:
    """All weights by name, in single precision."""
    return {
        weights.name.removesuffix("_half"): numpy_helper.to_array(weights).astype(np.float32)
        for weights in model.graph.initializer
    }


def _convolutions(model: onnx.ModelProto) -> list[tuple[str, str]]:
    """Names of the kernel and the bias of each convolution, in the order in which they run."""
    return [(n.input[1], n.input[2]) for n in model.graph.node if n.op_type == "Conv"]


def _settings(weights: Weights, convolutions: list[tuple[str, str]]) -> NetSettings:
    at_64, at_32, at_16, at_8 = (len(weights[convolutions[first][0]]) for first in _FIRST_AT)
    return NetSettings((at_64, at_32, at_16, at_8), weights["weight"].shape[1])


@torch.no_grad()
def _fill(net: JointNet, weights: Weights, convolutions: list[tuple[str, str]]) -> None:
    """Put the weights in their places; normalisation is left to add the bias alone."""
    layers = _in_order(net)
    kernels = [layer for layer in layers if isinstance(layer, nn.Conv2d)]
    if len(kernels) != len(convolutions):
        raise ValueError(f"{len(convolutions)} convolutions, not {len(kernels)}")
    names = dict(zip(kernels, convolutions, strict=True))
    for layer, following in zip(layers, [*layers[1:], None], strict=True):
        if not isinstance(layer, nn.Conv2d):
            continue
        kernel, bias = (torch.from_numpy(weights[name]) for name in names[layer])
        layer.weight.copy_(kernel)
        if isinstance(following, nn.BatchNorm2d):
            following.running_mean, following.running_var = -bias, torch.ones_like(bias)
            following.running_var -= following.eps
        elif layer.bias is not None:
            layer.bias.copy_(bias)
    for name in ("weight", "bias", "whole.weight", "whole.bias"):
        net.get_parameter(name).copy_(torch.from_numpy(weights[name]))


@torch.no_grad()
def _normalise(net: JointNet, images: Tensor) -> None:
    """Let every normalisation expect what these windows bring, and change nothing by it."""

    def adapt(layer: Any, inputs: tuple[Tensor, ...], _: Tensor) -> None:
        mean = inputs[0].mean(dim=(0, 2, 3))
        variance = inputs[0].var(dim=(0, 2, 3), correction=0)
        layer.bias.copy_(mean - layer.running_mean)
        layer.weight.copy_(torch.sqrt(variance + layer.eps))
        layer.running_mean.copy_(mean)
        layer.running_var.copy_(variance)

    _run(net, images, nn.BatchNorm2d, adapt)


def _in_order(net: JointNet) -> list[nn.Module]:
    """Convolutions and normalisations in the order in which they run."""
    layers: list[nn.Module] = []
    images = torch.zeros(1, 3, WINDOW_PIXELS, WINDOW_PIXELS)
    _run(net, images, (nn.Conv2d, nn.BatchNorm2d), lambda layer, *_: layers.append(layer))
    return layers


@torch.no_grad()
def _run(net: JointNet, images: Tensor, kinds: Any, hook: Callable[..., None]) -> None:
    """Run the network once, with a hook after all layers of some kinds."""
    handles = [
        layer.register_forward_hook(hook) for layer in net.modules() if isinstance(layer, kinds)
    ]
    net.eval()(images)
    for handle in handles:
        handle.remove()
