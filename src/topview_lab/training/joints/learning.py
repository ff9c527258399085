"""The training loop: resumable after every few minutes, the same for the same seed and batches."""

from __future__ import annotations

import ctypes
import io
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional
from torch.utils.data import DataLoader, Dataset, Sampler

from topview.io import write_atomically
from topview.records import InputError
from topview_lab.training.joints.net import JointNet, NetSettings
from topview_lab.training.joints.recordings import Samples
from topview_lab.training.joints.windows import (
    SHOULDERS_AND_HIPS,
    LabelledWindow,
    Variation,
    labelled_window,
)

CHECKPOINT_FORMAT: Final = "topview joints training 2"
CPU: Final = torch.device("cpu")
_MALLOC_PARAMETERS: Final = {-1: 2**31 - 1, -4: 0, -2: 2**28}
"""M_TRIM_THRESHOLD, M_MMAP_MAX and M_TOP_PAD of <malloc.h>."""
_LEFT, _RIGHT = SHOULDERS_AND_HIPS.tolist()


@dataclass(frozen=True, slots=True)
class LearningSettings:
    """How the network learns (ours).

    Attributes:
        windows: in all.
        batch: windows at once.
        rate, warm_up, decay: AdamW's greatest step, share of the training until it is reached, and
            weight decay; the step then falls as a cosine does.
        average: of the weights, over about 1 / (1 - average) batches.
        facing_sharpness: of who faces the camera: that of a logistic function of the sine between
            the camera's direction and the line from one side to the other. Whoever stands sideways
            teaches both modes.
        distance_weight, likelihood_weight: of the mean distance in box units, and of the Laplace
            law's negative logarithm.
        mode_weight, person_weight, visible_weight: of choosing the mode, knowing a person, and the
            visible mask.
        seed: of the network, the order and the variations.
    """

    windows: int = 600_000
    batch: int = 64
    rate: float = 2e-3
    warm_up: float = 0.03
    decay: float = 0.02
    average: float = 0.999
    facing_sharpness: float = 6.0
    distance_weight: float = 10.0
    likelihood_weight: float = 0.5
    mode_weight: float = 0.3
    person_weight: float = 0.3
    visible_weight: float = 0.3
    seed: int = 0

    @property
    def steps(self) -> int:
        """Batches in all."""
        return max(1, self.windows // self.batch)


class _Windows(Dataset[tuple[Any, ...]]):
    """Varied windows; which and how follows from the seed and the number of the window alone."""

    def __init__(self, samples: Samples, how: Variation, seed: int) -> None:
        self._samples, self._how, self._seed = samples, how, seed

    def __len__(self) -> int:
        return len(self._samples)

    def __getitem__(self, number: int) -> tuple[Any, ...]:
        rng = np.random.default_rng((self._seed, number))
        sample = int(rng.integers(len(self._samples)))
        return _as_arrays(labelled_window(self._samples, sample, rng, self._how))


class _InTurn(Sampler[int]):
    """The numbers from `first` to `last`."""

    def __init__(self, first: int, last: int) -> None:
        self._numbers = range(first, last)

    def __iter__(self) -> Iterator[int]:
        return iter(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)


def first_windows(samples: Samples, how: Variation, seed: int, count: int) -> Tensor:
    """[count, 3, 128, 128] the windows that a training begins with."""
    windows = _Windows(samples, how, seed)
    return torch.from_numpy(np.stack([windows[number][0] for number in range(count)]))


def _as_arrays(window: LabelledWindow) -> tuple[Any, ...]:
    return (
        window.image,
        window.places,
        window.is_known,
        window.visible,
        np.float32(window.is_person),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """What one batch cost: the mean of each term since the last report."""

    step: int
    steps: int
    terms: dict[str, float]
    windows_a_second: float


def losses(
    net: JointNet,
    image: Tensor,
    places: Tensor,
    is_known: Tensor,
    visible: Tensor,
    is_person: Tensor,
    how: LearningSettings,
) -> dict[str, Tensor]:
    """Each term of the loss, weighted."""
    with torch.autocast(image.device.type, torch.bfloat16, enabled=_has_halves(image.device)):
        found, log_scales, modes, person, mask = net(image)
    weights = (
        is_known.float()[:, None, :, None] / is_known.sum(dim=1).clamp(min=1)[:, None, None, None]
    )
    apart = (found - places[:, None]).abs()
    distance = (apart * weights).sum(dim=(2, 3))
    likelihood = ((apart / log_scales.exp() + log_scales) * weights).sum(dim=(2, 3))
    of_mode = how.distance_weight * distance + how.likelihood_weight * likelihood
    share = mode_shares(places, is_known, how.facing_sharpness)
    has_joints = is_known.any(dim=1).float()
    taught = has_joints.sum().clamp(min=1.0)
    choice = functional.cross_entropy(modes, share, reduction="none")
    return {
        "joints": (of_mode * share).sum() / taught,
        "mode": how.mode_weight * (choice * has_joints).sum() / taught,
        "person": how.person_weight
        * functional.binary_cross_entropy_with_logits(person, is_person),
        "visible": how.visible_weight * functional.binary_cross_entropy_with_logits(mask, visible),
    }


def _has_halves(device: torch.device) -> bool:
    """Whether half precision is quick there: a processor that only imitates it takes ten times as
    long with it."""
    return device.type != CPU.type or torch.ops.mkldnn._is_mkldnn_bf16_supported()


def mode_shares(places: Tensor, is_known: Tensor, sharpness: float) -> Tensor:
    """[B, 2] how much each person's joints are those of the mode that faces the camera, and of the
    one that is turned away; halves where no pair of shoulders or hips is known."""
    pairs = is_known[:, _LEFT] & is_known[:, _RIGHT]
    across = ((places[:, _LEFT] - places[:, _RIGHT]) * pairs[..., None]).sum(dim=1)
    sine = across[:, 0] / torch.linalg.vector_norm(across[:, ::2], dim=1).clamp(min=1e-6)
    facing = torch.sigmoid(sharpness * sine)
    return torch.stack([facing, 1.0 - facing], dim=1)


def learn(
    samples: Samples,
    net_settings: NetSettings,
    how: LearningSettings,
    variation: Variation,
    checkpoint: Path,
    report: Callable[[Step], None],
    *,
    begun: JointNet | None = None,
    device: torch.device = CPU,
    workers: int = 1,
    report_steps: int = 50,
    save_s: float = 120.0,
) -> JointNet:
    """The trained network, with averaged weights; goes on from the checkpoint where there is one.

    Args:
        samples: to learn from.
        net_settings: of the network.
        how: it learns.
        variation: of the windows.
        checkpoint: to write, and to go on from.
        report: is told every so many steps.
        begun: a network of these settings to start from; else it starts from chance.
        device: that learns.
        workers: processes that vary windows meanwhile; what is learnt does not depend on them.
        report_steps: between two reports.
        save_s: between two checkpoints, seconds.

    Raises:
        InputError: the checkpoint is of another kind, or cannot be written.
    """
    _keep_freed_memory()
    torch.manual_seed(how.seed)
    net = JointNet(net_settings)
    if begun is not None:
        net.load_state_dict(begun.state_dict())
    net.to(device, memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
    averaged = JointNet(net_settings).to(device)
    averaged.load_state_dict(net.state_dict())
    optimizer = torch.optim.AdamW(net.parameters(), how.rate, weight_decay=how.decay)
    done = _resume(checkpoint, net, averaged, optimizer, net_settings, how)
    loader = DataLoader(
        _Windows(samples, variation, how.seed),
        how.batch,
        sampler=_InTurn(done * how.batch, how.steps * how.batch),
        num_workers=workers,
        pin_memory=device != CPU,
        drop_last=True,
        prefetch_factor=4,
        worker_init_fn=_one_thread,
    )
    sums: dict[str, float] = {}
    since = 0
    saved_s = reported_s = time.monotonic()
    net.train()
    for step, (image, *labels) in enumerate(loader, done + 1):
        rate = how.rate * _rate_share(step / how.steps, how.warm_up)
        for group in optimizer.param_groups:
            group["lr"] = rate
        optimizer.zero_grad(set_to_none=True)
        image = image.to(device, memory_format=torch.channels_last, non_blocking=True)
        places, is_known, visible, is_person = (
            label.to(device, non_blocking=True) for label in labels
        )
        terms = losses(net, image, places, is_known, visible, is_person, how)
        torch.stack(list(terms.values())).sum().backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 5.0)
        optimizer.step()
        _average(averaged, net, min(how.average, step / (step + 10)))
        for name, term in terms.items():
            sums[name] = sums.get(name, 0.0) + float(term.detach())
        since += 1
        now_s = time.monotonic()
        if step % report_steps == 0 or step == how.steps:
            means = {name: total / since for name, total in sums.items()}
            report(Step(step, how.steps, means, since * how.batch / (now_s - reported_s)))
            sums, since, reported_s = {}, 0, now_s
        if now_s - saved_s > save_s or step == how.steps:
            _save(checkpoint, step, net, averaged, optimizer, net_settings, how)
            saved_s = now_s
    return averaged.eval().to(CPU)


def _keep_freed_memory() -> None:
    """Let the GNU C library keep what is freed: giving it back and asking for it anew at every
    batch takes four times as long as learning."""
    if sys.platform == "linux":
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            for parameter, value in _MALLOC_PARAMETERS.items():
                mallopt(parameter, value)


def _one_thread(_: int) -> None:
    torch.set_num_threads(1)


def _rate_share(done: float, warm_up: float) -> float:
    if done < warm_up:
        return done / warm_up
    return 0.5 * (1.0 + math.cos(math.pi * (done - warm_up) / (1.0 - warm_up))) + 1e-3


@torch.no_grad()
def _average(averaged: JointNet, net: JointNet, share: float) -> None:
    for mean, now in zip(averaged.parameters(), net.parameters(), strict=True):
        mean.lerp_(now, 1.0 - share)
    for mean, now in zip(averaged.buffers(), net.buffers(), strict=True):
        mean.copy_(now)


@torch.no_grad()
def mean_of(nets: Sequence[JointNet], counts: Sequence[float]) -> JointNet:
    """The network whose weights are the mean of others that have learnt from the same beginning on,
    or are that: it knows more than each, and forgets less (Wortsman et al., ICML 2022, CVPR 2022).

    The layers that tell people are the first one's: they were fitted by themselves, to what the
    tracker asks (`topview train-people`), and forget that where joints are learnt.

    Args:
        nets: of the same settings.
        counts: how much each counts, 1 in all.
    """
    own = JointNet(nets[0].settings)
    of_nets = [dict(net.named_parameters()) | dict(net.named_buffers()) for net in nets]
    for name, mean in (*own.named_parameters(), *own.named_buffers()):
        parts = (count * of_net[name] for count, of_net in zip(counts, of_nets, strict=True))
        mean.copy_(torch.stack(list(parts)).sum(dim=0))
    own.person.load_state_dict(nets[0].person.state_dict())
    return own.eval()


def _save(
    path: Path,
    step: int,
    net: JointNet,
    averaged: JointNet,
    optimizer: torch.optim.Optimizer,
    net_settings: NetSettings,
    how: LearningSettings,
) -> None:
    state = {
        "format": CHECKPOINT_FORMAT,
        "net_settings": net_settings.as_json(),
        "windows": how.windows,
        "batch": how.batch,
        "seed": how.seed,
        "step": step,
        "net": net.state_dict(),
        "averaged": averaged.state_dict(),
        "optimizer": optimizer.state_dict(),
    }
    data = io.BytesIO()
    torch.save(state, data)
    write_atomically(path, data.getvalue())


def _resume(
    path: Path,
    net: JointNet,
    averaged: JointNet,
    optimizer: torch.optim.Optimizer,
    net_settings: NetSettings,
    how: LearningSettings,
) -> int:
    """Load the checkpoint if there is one; how many batches it has learnt."""
    if not path.exists():
        return 0
    state = load_checkpoint(path)
    expected = {
        "net_settings": NetSettings.from_json(state["net_settings"]) == net_settings,
        "windows": state["windows"] == how.windows,
        "batch": state["batch"] == how.batch,
        "seed": state["seed"] == how.seed,
    }
    for name, is_same in expected.items():
        if not is_same:
            raise InputError(
                f"{path} was begun with another {name}; train with the same one, or remove it"
            )
    net.load_state_dict(state["net"])
    averaged.load_state_dict(state["averaged"])
    optimizer.load_state_dict(state["optimizer"])
    return int(state["step"])


def load_checkpoint(path: Path) -> dict[str, Any]:
    """What a training wrote.

    Raises:
        InputError: it is damaged or of another kind.
    """
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:
        raise InputError(f"{path} is no checkpoint that can be read ({error})") from None
    if not isinstance(state, dict) or state.get("format") != CHECKPOINT_FORMAT:
        raise InputError(f"{path} is no checkpoint of `topview train-joints`")
    return state


def trained_net(path: Path) -> JointNet:
    """The averaged network of a checkpoint."""
    state = load_checkpoint(path)
    net = JointNet(NetSettings.from_json(state["net_settings"]))
    net.load_state_dict(state["averaged"])
    return net.eval()
