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
from topview_lab.training.person_head import PERSON_LAYERS

Weights = dict[str, NDArray[np.float32]]
Convolutions = dict[str, tuple[str, str]]
"""Names of the kernel and the bias of each convolution, by the name of the node."""

_FIRST_AT = "stem.0", "down_32.0.body.0", "down_16.0.body.0", "down_8.0.body.0"
"""Of the convolutions: the first at 64, 32, 16 and 8 pixels a side."""
_NOT_CONVOLUTIONS = "weight", "bias", "modes.weight", "modes.bias", *PERSON_LAYERS


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
    stored = {own.name: numpy_helper.to_array(own) for own in model.graph.initializer}
    whole = {
        node.output[0]: _in_steps(*(stored[name] for name in node.input))
        for node in model.graph.node
        if node.op_type == "DequantizeLinear" and node.input[0] in stored
    }
    # Before there were whole numbers, weights were stored in half precision under other names.
    return whole | {
        name.removesuffix("_half"): values.astype(np.float32) for name, values in stored.items()
    }


def _in_steps(
    values: NDArray[Any], steps: NDArray[np.float32], zeros: NDArray[Any]
) -> NDArray[np.float32]:
    """Whole numbers times the size of a step, which may be another for each first index."""
    shape = -1, *(1,) * (values.ndim - 1)
    whole = values.astype(np.int32) - zeros.astype(np.int32).reshape(shape)
    return whole.astype(np.float32) * steps.reshape(shape)


def _convolutions(model: onnx.ModelProto) -> Convolutions:
    return {n.name: (n.input[1], n.input[2]) for n in model.graph.node if n.op_type == "Conv"}


def _node(layer: str) -> str:
    """What a convolution of `JointNet` is called in the file: `/stem/stem.0/Conv` is `stem.0`."""
    scopes: list[str] = []
    for part in layer.split("."):
        scopes.append(f"{scopes[-1]}.{part}" if part.isdigit() else part)
    return "/" + "/".join(scopes) + "/Conv"


def _settings(weights: Weights, convolutions: Convolutions) -> NetSettings:
    at_64, at_32, at_16, at_8 = (len(weights[convolutions[_node(own)][0]]) for own in _FIRST_AT)
    return NetSettings((at_64, at_32, at_16, at_8), weights["weight"].shape[1])


@torch.no_grad()
def _fill(net: JointNet, weights: Weights, convolutions: Convolutions) -> None:
    """Put the weights in their places; normalisation is left to add the bias alone."""
    layers = _in_order(net)
    names = {
        layer: convolutions.pop(_node(name))
        for name, layer in net.named_modules()
        if isinstance(layer, nn.Conv2d)
    }
    if convolutions:
        raise ValueError(f"it has a convolution {min(convolutions)}")
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
    for name in _NOT_CONVOLUTIONS:
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
