"""The layer that tells windows with people: what is read, fitted, written and collected."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

pytest.importorskip("onnx", reason="learning the layer needs the extra `train`")

from test_people_fit import MadeUpJob

from labelled_people import discs, write_recording
from skeleton_sequences import write_rendered
from topview.detect.joints.network import INPUT, OUTPUTS, WEIGHTS, opened
from topview.detect.joints.windows import DEPTH, OTHER, OWN, WINDOW_PIXELS
from topview.people.likelihood import Likelihood
from topview.records import InputError
from topview_lab.cli import train_people as command
from topview_lab.cli import train_people_layer
from topview_lab.datasets import SimulatedScene
from topview_lab.training.joints.windows import put_into_room
from topview_lab.training.people_fit import (
    fit_person_layer,
    windows_called_right,
)
from topview_lab.training.people_windows import (
    VARIED_WINDOWS,
    CollectedWindows,
    PosturesJob,
    WindowRows,
    WindowsJob,
)
from topview_lab.training.person_layer import layer_in, means_under, with_layer

SHIPPED = WEIGHTS.read_bytes()
RNG = np.random.default_rng(0)
IMAGES = RNG.uniform(-1.0, 1.0, (2, 3, WINDOW_PIXELS, WINDOW_PIXELS)).astype(np.float32)


def answers(weights: bytes) -> dict[str, np.ndarray]:
    run = opened(weights).run
    told = [run(list(OUTPUTS), {INPUT: image[None]}) for image in IMAGES]
    return {name: np.concatenate(own) for name, *own in zip(OUTPUTS, *told, strict=True)}


def test_the_layer_tells_of_its_means_what_the_network_tells_of_a_window() -> None:
    bias, layer = layer_in(SHIPPED)
    said = bias + means_under(SHIPPED)(IMAGES) @ layer
    assert_allclose(said, answers(SHIPPED)["person_logit"], atol=1e-4)


def test_another_layer_changes_nothing_but_who_is_a_person() -> None:
    bias, layer = layer_in(SHIPPED)
    changed = with_layer(SHIPPED, bias + 2.0, 0.5 * layer)
    assert_allclose(layer_in(changed)[0], bias + 2.0, atol=1e-6)
    assert_allclose(layer_in(changed)[1], 0.5 * layer, atol=1e-3)
    before, now = answers(SHIPPED), answers(changed)
    for name in OUTPUTS[:-1]:
        assert_array_equal(now[name], before[name])
    assert (now["person_logit"] != before["person_logit"]).all()


def made_up(seed: int = 0, count: int = 1000) -> WindowRows:
    """The first mean tells who is a person, of others' windows the more so; the second nothing."""
    rng = np.random.default_rng(seed)
    is_person = rng.random(count) < 0.5
    means = rng.normal(0.0, 1.0, (count, len(layer_in(SHIPPED)[1]))).astype(np.float32)
    means[:, 0] += np.where(is_person, 2.0, -2.0)
    return WindowRows(means, is_person, rng.random(count) < 0.3)


def test_what_tells_people_is_weighed() -> None:
    rows = made_up()
    bias, layer = fit_person_layer(rows)
    assert layer[0] > 5.0 * abs(layer[1])
    for is_varied in (False, True):
        assert min(windows_called_right(made_up(1), (bias, layer), is_varied)) > 0.8


def test_neither_units_nor_how_many_windows_were_varied_matter() -> None:
    rows = made_up()
    bias, layer = fit_person_layer(rows)
    in_halves = fit_person_layer(replace(rows, means=2.0 * rows.means))
    assert_allclose(2.0 * in_halves[1], layer, atol=0.01)
    varied = WindowRows(
        rows.means[rows.is_varied], rows.is_person[rows.is_varied], rows.is_varied[rows.is_varied]
    )
    often = fit_person_layer(WindowRows.joined([rows, varied, varied]))
    assert_allclose(np.append(often[1], often[0]), np.append(layer, bias), atol=0.05)


def test_one_kind_alone_teaches_nothing() -> None:
    rows = made_up()
    with pytest.raises(InputError, match="no piece of furniture was shown"):
        fit_person_layer(replace(rows, is_person=rows.is_person | ~rows.is_varied))


@pytest.mark.slow
def test_what_the_tracker_asks_of_a_simulated_person() -> None:
    collected = WindowsJob(SimulatedScene("stand", frames=3), None, None, WEIGHTS)()
    assert collected.rows is not None
    assert collected.rows.is_person.any()
    assert not collected.rows.is_varied.any()
    assert collected.rows.means.shape[1] == len(layer_in(SHIPPED)[1])


def test_who_is_seen_elsewhere_stays_the_same(tmp_path) -> None:
    """Other people's rooms teach, too: what is nobody's changes, and nothing else."""
    one, other = (write_recording(tmp_path / name, discs()) for name in ("a", "b"))
    scene = SimulatedScene("stand", frames=2)
    alone, also = (WindowsJob(scene, one, room, WEIGHTS)() for room in (None, other))
    assert alone.rows is not None
    assert also.rows is not None
    more = len(also.rows.means) - len(alone.rows.means)
    assert 0 < more <= VARIED_WINDOWS
    assert also.rows.is_varied[-more:].all()
    image, donor = IMAGES.copy()
    image[OWN:], donor[OWN:] = RNG.random((2, 2, WINDOW_PIXELS, WINDOW_PIXELS)) < 0.3
    before = image.copy()
    put_into_room(image, donor)
    is_ones = (image[OWN] + image[OTHER] > 0.0) | (donor[OWN] + donor[OTHER] > 0.0)
    assert_array_equal(image[:, is_ones], before[:, is_ones])
    assert_array_equal(image[DEPTH, ~is_ones], donor[DEPTH, ~is_ones])


def test_somebody_in_postures_teaches_varied_windows_alone() -> None:
    collected = PosturesJob(0, WEIGHTS)()
    assert collected.rows is not None
    assert collected.rows.is_varied.all()
    assert 0.5 < collected.rows.is_person.mean() < 1.0


def test_postures_teach_the_layer_alone(tmp_path, topview) -> None:
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
        return CollectedWindows(self.name, made_up(int(self.name[-1])))


def test_the_command_writes_both(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "CollectJob", lambda recording, _: MadeUpJob(recording))
    monkeypatch.setattr(train_people_layer, "WindowsJob", MadeUpWindows)
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
    _, layer = fit_person_layer(WindowRows.joined([made_up(k) for k in (1, 2, 4)]))
    assert_allclose(layer_in(joints.read_bytes())[1], layer, atol=0.01)
    source = msgspec.json.decode(out.read_bytes(), type=Likelihood).source
    assert source.endswith("topview train-people all --joints-out a.onnx")


def test_without_onnx_it_is_one_line(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "onnx", None)
    refused = topview("train-people", tmp_path, "--joints-out", tmp_path / "a.onnx")
    assert (refused.status, refused.complaints) == (
        2,
        ["topview: --joints-out needs onnx; install it with: pip install 'topview[train]'"],
    )
