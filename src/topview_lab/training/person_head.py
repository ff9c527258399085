"""The joint network's last layers, which tell whether a window shows a person.

They see how sure the network is of the joints, and means over the window. These, and all that the
network says of joints, stay as they were learnt. The layers go on learning from the very windows
that the tracker asks about, which they could not have seen while the network was learnt.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from topview.detect.joints.network import INPUT, opened
from topview.records import InputError

Floats = NDArray[np.float32]
Vector = NDArray[np.float64]

PERSON_LAYERS: Final = (
    "person.hidden.weight",
    "person.hidden.bias",
    "person.out.weight",
    "person.out.bias",
)
"""As `topview_lab.training.joints.net.PersonHead` names them."""
UNITS: Final = 16  # of the layer between (ours)
# On the squares of how far the weights go from what they were, in units of the spread of what the
# head sees; of 3e-4 to 1e-1 those from 1e-2 on told most of the recordings held back, and more
# than weights that were learnt from nothing.
PENALTY: Final = 3e-2
# What hardly varies is not scaled up (ours).
LEAST_SPREAD: Final = 1e-3
# Fitting ends here: what is told hardly changes any more (ours).
HEAD_PRECISION: Final = {"ftol": 1e-9, "gtol": 1e-7, "maxiter": 400}


@dataclass(frozen=True, slots=True, eq=False)
class PersonHead:
    """What `topview_lab.training.joints.net.PersonHead` computes.

    Attributes:
        hidden: [U, C] weights of each unit, and [U] their biases.
        out: [U] what each unit counts, and the bias.
    """

    hidden: tuple[Vector, Vector]
    out: tuple[Vector, float]

    @property
    def size(self) -> int:
        """C, of what it sees."""
        return self.hidden[0].shape[1]

    def log_odds(self, seen: NDArray[Any]) -> Vector:
        """[N] that a person is shown, of [N, C]."""
        weights, biases = self.hidden
        counts, bias = self.out
        return np.tanh(seen @ weights.T + biases) @ counts + bias


def seen_under(weights: bytes) -> Callable[[Floats], Floats]:
    """What gives, of [P, 3, 128, 128] windows, the [P, C] that the head sees.

    Raises:
        InputError: weights that cannot be used.
    """
    import onnx  # extra `train`

    model = onnx.load_model_from_string(weights)
    name = _first_of(model).input[0]
    model.graph.output.append(
        onnx.helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, None)
    )
    run = opened(model.SerializeToString()).run

    def seen(images: Floats) -> Floats:
        one_by_one = [run([name], {INPUT: image[None]})[0] for image in images]
        return np.concatenate(one_by_one)

    return seen


def head_in(weights: bytes) -> PersonHead:
    """The head of a weights file.

    Raises:
        InputError: it has none.
    """
    import onnx

    model = onnx.load_model_from_string(weights)
    _first_of(model)
    values = {own.name: onnx.numpy_helper.to_array(own) for own in model.graph.initializer}
    hidden, biases, counts, bias = (values[name].astype(np.float64) for name in PERSON_LAYERS)
    return PersonHead((hidden, biases), (counts[0], float(bias[0])))


def with_head(weights: bytes, head: PersonHead) -> bytes:
    """The weights file with another head, all else as it was."""
    import onnx

    model = onnx.load_model_from_string(weights)
    (hidden, biases), (counts, bias) = head.hidden, head.out
    new = dict(zip(PERSON_LAYERS, (hidden, biases, counts[None], np.array([bias])), strict=True))
    for own in model.graph.initializer:
        if own.name in new:
            values = new[own.name].astype(np.float32)
            own.CopyFrom(onnx.numpy_helper.from_array(values, own.name))
    return model.SerializeToString()


def _first_of(model: Any) -> Any:
    """The head's first layer."""
    for node in model.graph.node:
        if PERSON_LAYERS[0] in node.input:
            return node
    raise InputError(
        f"weights have no {PERSON_LAYERS[0]}; they must come from `topview train-joints`"
    )


def fitted_head(
    before: PersonHead, seen: Floats, is_person: NDArray[np.bool_], counts: Vector
) -> PersonHead:
    """The head that makes who is a person likeliest, learnt on from another.

    Args:
        before: that other one.
        seen: [N, C].
        is_person: [N].
        counts: [N] how much each window counts.
    """
    shares = counts / counts.sum()
    middle = seen.mean(axis=0, dtype=np.float64)
    spread = seen.std(axis=0, dtype=np.float64) + LEAST_SPREAD
    scaled = (seen - middle) / spread
    size = before.size
    ends = np.cumsum([UNITS * size, UNITS, UNITS])
    (weights, biases), (counted, bias) = before.hidden, before.out
    start = np.concatenate([(weights * spread).ravel(), biases + weights @ middle, counted, [bias]])
    is_held = np.ones(len(start), np.bool_)  # biases go where they like
    is_held[ends[0] : ends[1]] = is_held[-1] = False

    def head_at(place: Vector) -> PersonHead:
        weights, biases, units, bias = np.split(place, ends)
        return PersonHead((weights.reshape(UNITS, size), biases), (units, float(bias[0])))

    def loss(place: Vector) -> tuple[float, Vector]:
        head = head_at(place)
        (weights, biases), (units, bias) = head.hidden, head.out
        told = np.tanh(scaled @ weights.T + biases)
        log_odds = told @ units + bias
        rates = np.logaddexp(0.0, log_odds) - is_person * log_odds
        errors = (expit(log_odds) - is_person) * shares
        below = errors[:, None] * units * (1.0 - told**2)
        slopes = (below.T @ scaled, below.sum(axis=0), told.T @ errors, errors.sum())
        way = np.where(is_held, place - start, 0.0)
        slope = np.concatenate([np.ravel(own) for own in slopes]) + 2.0 * PENALTY * way
        return float(shares @ rates + PENALTY * (way @ way)), slope

    fitted = minimize(loss, start, jac=True, method="L-BFGS-B", options=HEAD_PRECISION)
    head = head_at(fitted.x)
    weights = head.hidden[0] / spread
    return PersonHead((weights, head.hidden[1] - weights @ middle), head.out)
