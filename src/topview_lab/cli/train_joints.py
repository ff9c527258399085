"""`topview train-joints`: the network that proposes joints, learnt from recordings with truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter
from rich.progress import TextColumn
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import progress_bar
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import opened
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.training.joints.measuring import INTERVALS, JointScores, Network, measure
from topview_lab.training.joints.pictures import AXES, draw_losses, draw_reliability
from topview_lab.training.joints.recordings import Samples, cached, folders_in, gathered, kept
from topview_lab.training.joints.simulated import check_postures, posture_recording

if TYPE_CHECKING:
    from torch import Tensor

    from topview_lab.training.joints.learning import LearningSettings, Step
    from topview_lab.training.joints.net import JointNet

MOST_WINDOWS = 100_000_000
MOST_AT_ONCE = 65_536
MOST_WORKERS = 256
MOST_RATE = 0.1
MEASURED_WINDOWS = 1000
START_WINDOWS = 256  # that tell a network to go on from what it sees
STARTED_RATE = 0.5  # of the rate of a network that starts from chance
TOLD_INTERVALS = (0.5, 0.9)


@dataclass(frozen=True, slots=True)
class _Machine:
    """What learns: a device by name; processes; threads, 0 for all."""

    device: str
    workers: int
    threads: int


@dataclass(frozen=True, slots=True)
class _Begun:
    """What is gone on from: the mean of weights, or chance; how much of it is kept; the network's
    widths, or those that the weights have."""

    start_from: Sequence[Path]
    keep: float
    widths: tuple[int, int, int, int] | None


def train_joints(
    folders: list[Path],
    /,
    *,
    out: Path,
    measure_on: Annotated[list[Path] | None, Parameter("--measure", negative="")] = None,
    start_from: Annotated[list[Path] | None, Parameter(consume_multiple=True, negative="")] = None,
    keep: float = 0.0,
    widths: tuple[int, int, int, int] | None = None,
    postures: int = 0,
    windows: int = 600_000,
    batch: int = 64,
    rate: float | None = None,
    seed: int = 0,
    device: Literal["cpu", "cuda"] | None = None,
    workers: int = 1,
    threads: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Learn to propose joints, for `--weights`.

    Reads recordings with depth, masks and truth into OUT.cache, trains, and writes the weights and
    a picture of the losses. A training that was stopped goes on where it was when the same command
    is given again; what it has learnt so far is in OUT.checkpoint. docs/joints.md tells more.

    Args:
        folders: recordings with groundtruth.npz and mask/, or folders of such.
        out: the .onnx to write; OUT.losses.json, OUT.losses.png, OUT.checkpoint and OUT.cache are
            written beside it, and OUT.reliability.png where it is measured.
        measure_on: recordings of other people, to measure the network on.
        start_from: weights to go on from, such as those that ship; of several that have gone on
            from the same the mean, which knows more than each, with the first one's layers that
            tell people. With --windows 0 they are only written anew, and measured.
        keep: how much the weights to go on from count in those that are written, 0 to 1: what is
            seldom among the recordings is then not forgotten.
        widths: of the network: channels at 64, 32, 16 and 8 pixels a side; of one to go on from, as
            many as it has or more, and what is new begins by saying nothing.
        postures: so many of our simulator's people to learn from besides, each in 40 postures that
            no capture shows: lying, sitting on the floor, kneeling, bent, on all fours; on
            a seat, ten times; and with hands on the own body, ten times.
        windows: to learn from, each varied anew.
        batch: windows that are learnt at once; on a GPU 512.
        rate: the greatest step of learning: by default 0.002, and half of it to go on from weights.
        seed: of the network, the order and the variations.
        device: that learns; by default a GPU where torch finds one.
        workers: processes that vary windows meanwhile: as many as there are cores beside a GPU.
        threads: of torch, 0 for all cores.
        force: replace the files that are there.
    """
    if not (windows > 0 or (windows == 0 and start_from)) or windows > MOST_WINDOWS:
        raise InputError(
            f"--windows is {windows}; it must be 1 to {MOST_WINDOWS}, or 0 with --start-from"
        )
    check_postures(postures)
    if not 1 <= batch <= MOST_AT_ONCE:
        raise InputError(f"--batch is {batch}; it must be 1 to {MOST_AT_ONCE}")
    if not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"--workers is {workers}; it must be 1 to {MOST_WORKERS}")
    if not 0.0 <= keep < 1.0 or (keep and not start_from):
        raise InputError(
            f"--keep is {keep}; it must be 0, or with --start-from more, and less than 1"
        )
    if rate is not None and not 0.0 < rate <= MOST_RATE:
        raise InputError(f"--rate is {rate}; it must be more than 0, at most {MOST_RATE}")
    if threads < 0:
        raise InputError(f"--threads is {threads}; it must be 0 (all cores) or more")
    if not 0 <= seed < 2**31:
        raise InputError(f"--seed is {seed}; it must be 0 to 2^31 - 1")
    _require_torch()
    machine = _Machine(_device(device), workers, threads)
    prepare_output_file("--out", out, force)
    samples = _read(folders, out, "learn from", postures)
    measured = _read(measure_on, out, "measure on") if measure_on else None
    from topview_lab.training.joints.learning import LearningSettings

    how = replace(LearningSettings(), windows=windows, batch=batch, seed=seed)
    begun_rate = how.rate * STARTED_RATE if start_from else how.rate
    how = replace(how, rate=begun_rate if rate is None else rate)
    begun_from = start_from or []
    network = _learn(samples, how, out, _Begun(begun_from, keep, widths), machine)
    anew = f"{', '.join(map(str, begun_from))} anew, by windows"
    learnt = f"trained on {windows} windows" if windows else anew
    print(f"{learnt} of {len(samples.recordings)} recordings; {out} written")
    if measured is not None:
        scores = _scores(network, measured)
        _report(scores, len(measured.recordings))
        draw_reliability(scores, _beside(out, "reliability.png"))


def _require_torch() -> None:
    try:
        import onnx  # noqa: F401
        import torch  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"train-joints needs torch and onnx ({error}); "
            "install them with: pip install 'topview[train]'"
        ) from error


def _device(asked: str | None) -> str:
    """The device that was asked for; else a GPU where torch finds one."""
    import torch

    there = "cuda" if torch.cuda.is_available() else "cpu"
    if asked == "cuda" and there == "cpu":
        raise InputError(
            "--device is cuda, but torch finds no GPU; leave it out to learn on the CPU"
        )
    return asked or there


def _beside(out: Path, ending: str) -> Path:
    return out.with_name(f"{out.name}.{ending}")


def _read(sources: Sequence[Path], out: Path, what_for: str, postures: int = 0) -> Samples:
    """All samples of these recordings, and of so many simulated people, through the cache."""
    found = list(folders_in(sources))
    recordings, cache = [], _beside(out, "cache")
    with progress_bar() as progress:
        bar = progress.add_task(f"reading what to {what_for}", total=len(found) + postures)
        for folder in found:
            recordings.append(cached(folder, cache))
            progress.advance(bar)
        for number in range(postures):
            place = cache / f"simulated_postures_seats_hands_{number}"
            recordings.append(kept(place, partial(posture_recording, number)))
            progress.advance(bar)
    samples = gathered(recordings)
    if not len(samples):
        raise InputError(
            f"the {len(found)} recordings to {what_for} show nobody; masks, present and ids of "
            "groundtruth.npz must tell who is where"
        )
    return samples


def _learn(
    samples: Samples,
    how: LearningSettings,
    out: Path,
    given: _Begun,
    machine: _Machine,
) -> Network:
    """Train, write the weights and the losses; what the network says of windows."""
    import torch

    from topview_lab.training.joints.export import exported
    from topview_lab.training.joints.growing import grown
    from topview_lab.training.joints.learning import first_windows, learn, mean_of
    from topview_lab.training.joints.net import NetSettings
    from topview_lab.training.joints.windows import Variation

    if machine.threads:
        torch.set_num_threads(machine.threads)
    varied, begun = Variation(), None
    images = first_windows(samples, varied, how.seed, START_WINDOWS)
    if given.start_from:
        begun = _mean_of_weights(given.start_from, images)
        begun = begun if given.widths is None else grown(begun, given.widths)
        if how.windows == 0:
            return _written(exported(begun.eval(), images), out)
    chance = NetSettings(given.widths or NetSettings().widths)
    settings = chance if begun is None else begun.settings
    history = _beside(out, "losses.json")
    checkpoint = _beside(out, "checkpoint")
    rows = json.loads(history.read_text()) if checkpoint.exists() and history.exists() else []
    rate = TextColumn("{task.fields[said]}")
    with progress_bar(rate) as progress:
        bar = progress.add_task("learning", total=how.steps, said="")

        def told(step: Step) -> None:
            done = step.step * how.batch
            # What was learnt after the last checkpoint is learnt, and told, again.
            rows[:] = [row for row in rows if row["windows"] < done]
            rows.append({"windows": done, **step.terms})
            write_atomically(history, json.dumps(rows).encode())
            said = f"{step.windows_a_second:.0f} windows/s"
            progress.update(bar, completed=step.step, said=said)

        net = learn(
            samples,
            settings,
            how,
            varied,
            checkpoint,
            told,
            begun=begun,
            device=torch.device(machine.device),
            workers=machine.workers,
        )
    draw_losses(rows, _beside(out, "losses.png"))
    if begun is not None:
        net = mean_of((begun, net), (given.keep, 1.0 - given.keep))
    return _written(exported(net, images), out)


def _mean_of_weights(paths: Sequence[Path], images: Tensor) -> JointNet:
    """Raises InputError where one cannot be read, or is of another size."""
    from topview_lab.training.joints.imported import imported
    from topview_lab.training.joints.learning import mean_of

    nets = [imported(path, images) for path in paths]
    for path, net in zip(paths, nets, strict=True):
        if net.settings != nets[0].settings:
            raise InputError(
                f"--start-from {path} is a network of another size than {paths[0]}; "
                "all of them must be of the same"
            )
    return mean_of(nets, [1.0 / len(nets)] * len(nets))


def _written(weights: bytes, out: Path) -> Network:
    """Write weights; what they say of windows."""
    write_atomically(out, weights)
    return opened(weights).answers


def _scores(network: Network, samples: Samples) -> JointScores:
    every = max(1, len(samples) // MEASURED_WINDOWS)
    with progress_bar() as progress:
        bar = progress.add_task("measuring", total=len(range(0, len(samples), every)))
        return measure(network, samples, every, lambda: progress.advance(bar))


def _report(scores: JointScores, recordings: int) -> None:
    table = Table("joint", title=f"{scores.windows} windows of {recordings} recordings, true masks")
    for heading in ("mean, cm", "within 10 cm, %", "90 % intervals hold, %"):
        table.add_column(heading, justify="right")
    rows = zip(
        (*PROPOSED_JOINTS, "mean"),
        (*scores.mean_m, scores.mean_m.mean()),
        (*scores.within, scores.within.mean()),
        (*scores.held, scores.held.mean(axis=0)),
        strict=True,
    )
    for name, mean_m, within, held in rows:
        axes = " ".join(f"{100 * share:.0f}" for share in held)
        table.add_row(name, f"{100 * mean_m:.1f}", f"{100 * within:.0f}", axes)
    plain_console().print(table)
    for name, held in (("in view", scores.held_in_view), ("hidden", scores.held_hidden)):
        for share in TOLD_INTERVALS:
            axes = zip(AXES, held[INTERVALS.index(share)], strict=True)
            said = ", ".join(f"{100 * part:.1f} % {axis}" for axis, part in axes)
            print(f"joints {name}: of the {100 * share:.0f} % intervals hold {said}")
    print(f"front and back told: {100 * scores.facing_told:.1f} % of those who show either")
    print(
        f"told to be a person: {100 * scores.people_told:.1f} % of the people; "
        f"told to be none: {100 * scores.things_told:.1f} % of pieces of the background"
    )
