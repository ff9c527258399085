"""The head that tells windows with people: what is read, fitted, written and collected."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

pytest.importorskip("onnx", reason="learning the head needs the extra `train`")

from test_people_fit import MadeUpJob

from labelled_people import discs, write_recording
from skeleton_sequences import write_rendered
from topview.detect.joints.network import INPUT, OUTPUTS, WEIGHTS, opened
from topview.detect.joints.windows import DEPTH, OTHER, OWN, WINDOW_PIXELS
from topview.people.likelihood import Likelihood
from topview.records import InputError
from topview_lab.cli import train_people as command
from topview_lab.cli import train_people_head
from topview_lab.datasets import SimulatedScene
from topview_lab.training.joints.windows import put_into_room
from topview_lab.training.people_fit import fit_person_head, windows_called_right
from topview_lab.training.people_windows import (
    VARIED_WINDOWS,
    CollectedWindows,
    PosturesJob,
    WindowRows,
    WindowsJob,
)
from topview_lab.training.person_head import (
    UNITS,
    PersonHead,
    head_in,
    seen_under,
    with_head,
)

SHIPPED = WEIGHTS.read_bytes()
SEEN = head_in(SHIPPED).size
RNG = np.random.default_rng(0)
IMAGES = RNG.uniform(-1.0, 1.0, (2, 3, WINDOW_PIXELS, WINDOW_PIXELS)).astype(np.float32)


def answers(weights: bytes) -> dict[str, np.ndarray]:
    run = opened(weights).run
    told = [run(list(OUTPUTS), {INPUT: image[None]}) for image in IMAGES]
    return {name: np.concatenate(own) for name, *own in zip(OUTPUTS, *told, strict=True)}


def test_the_head_tells_of_what_it_sees_what_the_network_tells_of_a_window() -> None:
    said = head_in(SHIPPED).log_odds(seen_under(SHIPPED)(IMAGES))
    assert_allclose(said, answers(SHIPPED)["person_logit"], atol=1e-4)


def test_another_head_changes_nothing_but_who_is_a_person() -> None:
    head = head_in(SHIPPED)
    units, bias = head.out
    changed = with_head(SHIPPED, PersonHead(head.hidden, (0.5 * units, bias + 2.0)))
    for now, then in zip(head_in(changed).hidden, head.hidden, strict=True):
        assert_array_equal(now, then)
    assert_allclose(head_in(changed).out[0], 0.5 * units, rtol=1e-6)
    assert_allclose(head_in(changed).out[1], bias + 2.0, rtol=1e-6)
    before, now = answers(SHIPPED), answers(changed)
    for name in OUTPUTS[:-1]:
        assert_array_equal(now[name], before[name])
    assert (now["person_logit"] != before["person_logit"]).all()


def made_up(seed: int = 0, size: int = 4) -> WindowRows:
    """People are in the middle of the first, which no sum tells, or high in the second; the others
    tell nothing."""
    rng, count = np.random.default_rng(seed), 1000
    is_person = rng.random(count) < 0.5
    seen = rng.normal(0.0, 1.0, (count, size)).astype(np.float32)
    side = np.where(rng.random(count) < 0.5, 4.0, -4.0)
    seen[:, 0] += np.where(is_person, 0.0, side)
    seen[:, 1] += np.where(is_person, 1.0, -1.0)
    return WindowRows(seen, is_person, rng.random(count) < 0.3)


def taught(*rows: WindowRows) -> PersonHead:
    """A head that knew nothing, after so many lessons."""
    rng = np.random.default_rng(0)
    hidden = rng.normal(0.0, 0.5, (UNITS, rows[0].seen.shape[1])), np.zeros(UNITS)
    head = PersonHead(hidden, (rng.normal(0.0, UNITS**-0.5, UNITS), 0.0))
    for each in rows:
        head = fit_person_head(head, each)
    return head


def test_people_are_told_also_where_no_sum_tells_them() -> None:
    head = taught(*[made_up()] * 6)
    for is_varied in (False, True):
        assert min(windows_called_right(made_up(1), head, is_varied)) > 0.95


def alike(said: np.ndarray, also_said: np.ndarray) -> bool:
    return bool(np.corrcoef(said, also_said)[0, 1] > 0.99)


def test_neither_units_nor_how_many_windows_were_varied_matter() -> None:
    rows = made_up()
    before = taught(rows)
    (weights, biases), out = before.hidden, before.out
    said = fit_person_head(before, rows).log_odds(rows.seen)
    moved = replace(rows, seen=2.0 * rows.seen + 3.0)
    also_before = PersonHead((weights / 2.0, biases - 1.5 * weights.sum(axis=1)), out)
    assert alike(fit_person_head(also_before, moved).log_odds(moved.seen), said)
    varied = WindowRows(
        rows.seen[rows.is_varied], rows.is_person[rows.is_varied], rows.is_varied[rows.is_varied]
    )
    often = fit_person_head(before, WindowRows.joined([rows, varied, varied]))
    assert alike(often.log_odds(rows.seen), said)


def test_one_kind_alone_teaches_nothing() -> None:
    rows = made_up()
    with pytest.raises(InputError, match="no piece of furniture was shown"):
        taught(replace(rows, is_person=rows.is_person | ~rows.is_varied))


@pytest.mark.slow
def test_what_the_tracker_asks_of_a_simulated_person() -> None:
    collected = WindowsJob(SimulatedScene("stand", frames=3), None, None, WEIGHTS)()
    assert collected.rows is not None
    assert collected.rows.is_person.any()
    assert not collected.rows.is_varied.any()
    assert collected.rows.seen.shape[1] == SEEN


def test_who_is_seen_elsewhere_stays_the_same(tmp_path) -> None:
    """Other people's rooms teach, too: what is nobody's changes, and nothing else."""
    one, other = (write_recording(tmp_path / name, discs()) for name in ("a", "b"))
    scene = SimulatedScene("stand", frames=2)
    alone, also = (WindowsJob(scene, one, room, WEIGHTS)() for room in (None, other))
    assert alone.rows is not None
    assert also.rows is not None
    more = len(also.rows.seen) - len(alone.rows.seen)
    assert 0 < more <= VARIED_WINDOWS
    assert also.rows.is_varied[-more:].all()
    image, donor = IMAGES.copy()
    image[OWN:], donor[OWN:] = RNG.random((2, 2, WINDOW_PIXELS, WINDOW_PIXELS)) < 0.3
    before = image.copy()
    put_into_room(image, donor)
    is_ones = (image[OWN] + image[OTHER] > 0.0) | (donor[OWN] + donor[OTHER] > 0.0)
    assert_array_equal(image[:, is_ones], before[:, is_ones])
    assert_array_equal(image[DEPTH, ~is_ones], donor[DEPTH, ~is_ones])


@pytest.mark.slow
def test_somebody_in_postures_teaches_held_and_varied_windows() -> None:
    rows = PosturesJob(0, WEIGHTS)().rows
    assert rows is not None
    assert np.count_nonzero(rows.is_varied) == VARIED_WINDOWS
    for is_kind in (rows.is_varied, ~rows.is_varied):
        assert 0.25 < rows.is_person[is_kind].mean() < 1.0


def test_postures_teach_the_head_alone(tmp_path, topview) -> None:
    for words, complaint in (
        (("--postures", "-1"), "--postures is -1; it must be 0 to 10000"),
        (("--postures", "3"), "--postures is 3; only --joints-out learns from them"),
    ):
        refused = topview("train-people", tmp_path, *words)
        assert (refused.status, refused.complaints) == (2, [f"topview: {complaint}"])


class MadeUpWindows:
    """Collects made-up windows; nothing of a recording that is called broken."""

    def __init__(self, recording, folder, room, weights) -> None:
        assert folder == recording.path
        assert room.parent == folder.parent
        assert room != folder
        self.name = recording.name

    def __call__(self) -> CollectedWindows:
        if self.name.startswith("broken"):
            return CollectedWindows(self.name, None, f"{self.name}: is broken")
        return CollectedWindows(self.name, made_up(int(self.name[-1]), SEEN))


def test_the_command_writes_both(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "CollectJob", lambda recording, _: MadeUpJob(recording))
    monkeypatch.setattr(train_people_head, "WindowsJob", MadeUpWindows)
    shares = {"person_occ_inter": np.zeros((1, 1)), "person_outside": np.zeros((1, 1))}
    for name in ("broken_0", "walk_1", "walk_2", "walk_3", "walk_4"):
        write_rendered(tmp_path / "all" / name, [2.0], **shares)
    out, joints = tmp_path / "a.json", tmp_path / "a.onnx"
    done = topview(
        *("train-people", tmp_path / "all", "--out", out, "--joints-out", joints, "--workers", 1)
    )
    assert done.status == 2
    assert done.complaints[0] == "topview: broken_0: is broken"
    assert "windows that the network tells right" in done.out
    assert all(len(line) <= 80 for line in done.out.splitlines()[:-1])
    rows = WindowRows.joined([made_up(k, SEEN) for k in (1, 2, 4)])
    head = fit_person_head(head_in(SHIPPED), rows)
    assert_allclose(head_in(joints.read_bytes()).out[0], head.out[0], rtol=1e-6)
    source = msgspec.json.decode(out.read_bytes(), type=Likelihood).source
    assert source.endswith("topview train-people all --joints-out a.onnx")


def test_without_onnx_it_is_one_line(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "onnx", None)
    refused = topview("train-people", tmp_path, "--joints-out", tmp_path / "a.onnx")
    assert (refused.status, refused.complaints) == (
        2,
        ["topview: --joints-out needs onnx; install it with: pip install 'topview[train]'"],
    )
