"""The network that proposes joints, run by onnxruntime, which no other file imports.

One run looks at one window, on one thread; windows are dealt to the threads that the kernels use
(`topview.kernels.threads`). What is proposed for somebody therefore depends neither on the number
of threads nor on who else is there, to the bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from topview.detect.joints.proposals import OTHER_SIDES, PROPOSED_JOINTS, JointProposals
from topview.detect.joints.windows import WINDOW_PIXELS, Windows
from topview.files import file_as_json, naming, read_bytes
from topview.kernels.threads import over_threads
from topview.records import InputError, shown

Floats = NDArray[np.float32]
Run = Callable[[list[str], dict[str, Floats]], Sequence[Any]]

WEIGHTS: Final = Path(__file__).parent / "data" / "joints.onnx"
"""Those that come with the project."""
WEIGHTS_FORMAT: Final = "topview joints 2"
"""Of a weights file, in its metadata."""
INPUT: Final = "windows"
OUTPUTS: Final = ("places", "log_scales", "mode_logits", "person_logit")
"""Places and natural logarithms of scales, both in units of the box, [P, M, J, 3]; [P, M]; [P]."""
VISIBLE: Final = "visible"
"""One more output: [P, 32, 32] logits of the person's own visible pixels."""
VISIBLE_PIXELS: Final = 32  # on each side, as of the heat maps

# All ours.
MOST_WEIGHTS_BYTES: Final = 2**27
MOST_LOG_SCALE: Final = 20.0  # scales are held to e^-20 to e^20 boxes
NEAREST_JOINT_M: Final = 0.1  # a proposed joint is no nearer to the camera
COUNTED_SHARE: Final = 0.5  # of all scales, in the modes' weights: joints err together
ONLY_FATAL: Final = 4  # what onnxruntime logs; errors are raised as well

WEIGHTS_RIGHT: Final = (
    "it must be weights that `topview train-joints` wrote; --proposals none tracks without any"
)


class JointNetwork:
    """A `JointProposer`: the network with the weights of a file."""

    def __init__(self, weights: Path | None = None) -> None:
        """Read the weights; a file of the same content is taken apart once in a process.

        Args:
            weights: written by `topview train-joints`; those of the project if None.

        Raises:
            InputError: missing, cut short, of another format, of other joints or shapes.
        """
        self._path = weights or WEIGHTS
        with naming(self._path, right=WEIGHTS_RIGHT):
            self._network = opened(_weights(self._path))

    def propose(self, windows: Windows) -> JointProposals:
        """Proposals for each window, in their order; weight 0 for those that are not used.

        Raises:
            InputError: the network cannot be run, or gives numbers that are not finite.
        """
        used = np.flatnonzero(windows.is_used)
        with naming(self._path):
            answers = self._network.answers(windows.looked_at[used])
        _mirror(answers, windows.is_mirrored[used])
        P, M, J = len(windows.is_used), self._network.modes, len(PROPOSED_JOINTS)
        places, log_scales = np.zeros((P, M, J, 3)), np.zeros((P, M, J, 3))
        weights, p_person = np.zeros((P, M)), np.zeros(P)
        places[used], log_scales[used] = answers["places"], answers["log_scales"]
        weights[used] = mode_weights(answers["mode_logits"], answers["log_scales"])
        p_person[used] = expit(answers["person_logit"].astype(np.float64))
        middle_m, half_m = windows.middles[:, None, None, 2], windows.halves_m[:, None, None]
        places[..., 2] = np.maximum(places[..., 2], (NEAREST_JOINT_M - middle_m) / half_m)
        scales_m = np.exp(np.clip(log_scales, -MOST_LOG_SCALE, MOST_LOG_SCALE)) * half_m[..., None]
        # What spans the box at its middle spans more behind it, and less before it.
        scales_m[..., :2] *= (1.0 + places[..., 2] * half_m / middle_m)[..., None]
        return JointProposals(
            windows.to_camera(places),
            scales_m,
            weights,
            p_person,
            PROPOSED_JOINTS,
        )


def _mirror(answers: dict[str, Floats], is_mirrored: NDArray[np.bool_]) -> None:
    """What was said of mirrored windows becomes what is true of the windows."""
    for name in ("places", "log_scales"):
        answers[name][is_mirrored] = answers[name][is_mirrored][:, :, OTHER_SIDES]
    answers["places"][is_mirrored, ..., 0] *= -1.0


def mode_weights(mode_logits: Floats, log_scales: Floats) -> NDArray[np.float64]:
    """[P, M] how likely each whole-body mode is: what the network says of it, and how sure it is of
    the mode's joints. A body that does not fit what is seen has wide scales, and this tells front
    from back where a real sensor's image misleads the logits.

    Args:
        mode_logits: [P, M].
        log_scales: [P, M, J, 3].
    """
    sureness = -COUNTED_SHARE * log_scales.astype(np.float64).sum(axis=(2, 3))
    logits = mode_logits.astype(np.float64) + sureness
    likely = np.exp(logits - logits.max(1, keepdims=True))
    return likely / likely.sum(1, keepdims=True)


def weights_as_json(weights: Path | None) -> dict[str, str]:
    """Which weights these are, in JSON types: the file's name and the start of its SHA-256.

    Raises:
        InputError: the file cannot be read.
    """
    path = weights or WEIGHTS
    with naming(path, right=WEIGHTS_RIGHT):
        return file_as_json(path, _weights(path))


def _weights(path: Path) -> bytes:
    return read_bytes(path, MOST_WEIGHTS_BYTES, WEIGHTS_RIGHT)


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A network that was opened.

    Attributes:
        run: `InferenceSession.run`: names of outputs and the inputs to arrays; threads may call it
            at the same time.
        modes: M.
    """

    run: Run
    modes: int

    def answers(self, images: Floats) -> dict[str, Floats]:
        """`OUTPUTS` for [P, 3, 128, 128] images."""
        M, J = self.modes, len(PROPOSED_JOINTS)
        count = len(images)
        shapes = (count, M, J, 3), (count, M, J, 3), (count, M), (count,)
        answers = {
            name: np.empty(shape, np.float32) for name, shape in zip(OUTPUTS, shapes, strict=True)
        }
        _answer(self.run, images, answers)
        if not all(np.isfinite(values).all() for values in answers.values()):
            raise InputError(f"gives numbers that are not finite; {WEIGHTS_RIGHT}")
        return answers


@over_threads("images")
def _answer(first: int, step: int, run: Run, images: Floats, answers: dict[str, Floats]) -> None:
    for index in range(first, len(images), step):
        one = slice(index, index + 1)
        try:
            outputs = run(list(OUTPUTS), {INPUT: images[one]})
            for name, values in zip(OUTPUTS, outputs, strict=True):
                answers[name][one] = values
        except MemoryError:
            raise
        except Exception:  # onnxruntime's own have no class in common
            raise InputError(f"cannot be run; {WEIGHTS_RIGHT}") from None


def silent_onnxruntime() -> ModuleType:
    """Import it, which takes a quarter of a second, so that it tells nobody: as it comes, it keeps
    an id of the machine and sends what it is used for to its makers."""
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"  # read once, while it is imported
    import onnxruntime

    onnxruntime.disable_telemetry_events()
    return onnxruntime


@lru_cache(maxsize=2)  # kept: the project's own and one more
def opened(weights: bytes) -> Network:
    """The network of a file's content.

    Raises:
        InputError: it is none, or another one.
    """
    onnxruntime = silent_onnxruntime()
    onnxruntime.set_default_logger_severity(ONLY_FATAL)
    options = onnxruntime.SessionOptions()
    options.log_severity_level = ONLY_FATAL
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.execution_mode = onnxruntime.ExecutionMode.ORT_SEQUENTIAL
    try:
        session = onnxruntime.InferenceSession(weights, options, providers=["CPUExecutionProvider"])
    except MemoryError:
        raise
    except Exception:  # onnxruntime's own have no class in common
        raise InputError(f"is no network, or not a whole one; {WEIGHTS_RIGHT}") from None
    about = session.get_modelmeta().custom_metadata_map
    if about.get("format") != WEIGHTS_FORMAT:
        raise InputError(
            f"its format is {shown(about.get('format'))}, not {WEIGHTS_FORMAT!r}; {WEIGHTS_RIGHT}"
        )
    if about.get("joint_names") != ",".join(PROPOSED_JOINTS):
        names = shown(about.get("joint_names"))
        raise InputError(
            f"its joints are {names}, not the network's of this version; {WEIGHTS_RIGHT}"
        )
    return Network(session.run, _modes(session.run))


def _modes(run: Run) -> int:
    """How many modes a network has; an empty window tells, and whether what comes out is right."""
    empty = np.zeros((1, 3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
    try:
        outputs = run([*OUTPUTS, VISIBLE], {INPUT: empty})
    except MemoryError:
        raise
    except Exception:  # onnxruntime's own have no class in common
        raise InputError(f"takes or gives something else; {WEIGHTS_RIGHT}") from None
    M, J = int(np.size(outputs[OUTPUTS.index("mode_logits")])), len(PROPOSED_JOINTS)
    right = [(1, M, J, 3), (1, M, J, 3), (1, M), (1,), (1, VISIBLE_PIXELS, VISIBLE_PIXELS)]
    for name, values, shape in zip([*OUTPUTS, VISIBLE], outputs, right, strict=True):
        if np.shape(values) != shape or M == 0:
            raise InputError(f"gives {name} of {np.shape(values)}, not {shape}; {WEIGHTS_RIGHT}")
        if not np.isfinite(values).all():
            raise InputError(f"gives {name} that are not finite; {WEIGHTS_RIGHT}")
    return M
