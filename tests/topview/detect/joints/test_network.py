"""The network: what it says does not depend on threads or company; a wrong file is one line."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tiny_networks import write_network
from topview.detect.joints import PROPOSED_JOINTS, JointProposals, Windows
from topview.detect.joints.network import (
    COUNTED_SHARE,
    JointNetwork,
    mode_weights,
    weights_as_json,
)
from topview.detect.joints.proposals import OTHER_SIDES
from topview.detect.joints.windows import HALF_BOX_M, LEAST_HALF_BOX_M, WINDOW_PIXELS
from topview.kernels.threads import use_threads
from topview.records import InputError

PEOPLE = 4


def windows_of(*people: int, unused: int | None = None) -> Windows:
    """Noise, another for each person."""
    images = [
        np.random.default_rng(person).random((3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
        for person in people
    ]
    middles = np.array([[100.0 + 30.0 * person, 120.0, 5.0 + 0.3 * person] for person in people])
    is_used = np.array([person != unused for person in people])
    halves_m = np.linspace(LEAST_HALF_BOX_M, HALF_BOX_M, PEOPLE)[list(people)]
    lens = 285.0, 285.0, 159.5, 119.5
    is_mirrored = np.zeros(len(people), np.bool_)
    return Windows(np.stack(images), middles, halves_m, is_used, *lens, is_mirrored)


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> JointNetwork:
    return JointNetwork(write_network(tmp_path_factory.mktemp("weights") / "tiny.onnx"))


@pytest.fixture
def threads() -> Iterator[None]:
    """Whatever number of threads a test sets, the next one has the usual."""
    yield
    use_threads(0)


def bits(proposals: JointProposals) -> bytes:
    arrays = proposals.positions_camera, proposals.scales_m, proposals.weights, proposals.p_person
    return b"".join(array.tobytes() for array in arrays)


@pytest.mark.usefixtures("threads")
def test_threads_and_company_change_no_bit(network: JointNetwork) -> None:
    use_threads(1)
    together = network.propose(windows_of(*range(PEOPLE)))
    use_threads(2)
    assert bits(network.propose(windows_of(*range(PEOPLE)))) == bits(together)
    alone = [bits(network.propose(windows_of(person))) for person in range(PEOPLE)]
    assert alone == [bits(together.of_person(person)) for person in range(PEOPLE)]
    assert len(set(alone)) == PEOPLE


def test_proposals_are_of_the_shapes_and_units_that_they_say(network: JointNetwork) -> None:
    windows = windows_of(0, 1, unused=1)
    proposals = network.propose(windows)
    assert proposals.joint_names == PROPOSED_JOINTS
    assert proposals.positions_camera.shape == (2, 2, len(PROPOSED_JOINTS), 3)
    assert proposals.weights.sum(1) == pytest.approx([1.0, 0.0])
    assert 0.0 < proposals.p_person[0] < 1.0
    assert proposals.p_person[1] == 0.0
    nothing = network.propose(windows_of(1, unused=1))
    assert bits(proposals.of_person(1)) == bits(nothing)
    assert (proposals.scales_m[1] == windows.halves_m[1]).all()
    assert len(network.propose(windows_of(0, unused=0)).weights) == 1


def test_what_is_looked_at_in_the_mirror_is_told_of_the_window(network: JointNetwork) -> None:
    """Of the second person alone."""
    windows = windows_of(0, 1)
    flipped = replace(windows, images=np.ascontiguousarray(windows.images[..., ::-1]))
    there = network.propose(replace(windows, is_mirrored=np.array([False, True])))
    here = network.propose(flipped)
    want = flipped.from_camera(here.positions_camera)[:, :, OTHER_SIDES] * [-1.0, 1.0, 1.0]
    assert windows.from_camera(there.positions_camera)[1] == pytest.approx(want[1], abs=1e-9)
    np.testing.assert_array_equal(there.scales_m[1], here.scales_m[1][:, OTHER_SIDES])
    np.testing.assert_array_equal(there.weights[1], here.weights[1])
    plain = network.propose(windows)
    np.testing.assert_array_equal(there.positions_camera[0], plain.positions_camera[0])
    np.testing.assert_array_equal(there.scales_m[0], plain.scales_m[0])


def test_places_are_in_units_of_the_box(tmp_path: Path) -> None:
    windows = windows_of(0, 1)
    there, further = (
        windows.from_camera(
            JointNetwork(write_network(tmp_path / "w.onnx", constant=constant))
            .propose(windows)
            .positions_camera
        )
        for constant in (0.0, 0.25)
    )
    assert further - there == pytest.approx(np.full(there.shape, 0.25), abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"format": "topview joints 0"}, "its format is 'topview joints 0'"),
        ({"joints": PROPOSED_JOINTS[:-1]}, "its joints are"),
        ({"joints": PROPOSED_JOINTS[::-1]}, "its joints are"),
        ({"pixels": 64}, "takes or gives something else"),
        ({"places_of": 20}, r"gives places of \(1, 2, 20, 3\), not \(1, 2, 21, 3\)"),
        ({"constant": float("nan")}, "gives places that are not finite"),
        ({"nan_on_people": True}, "gives numbers that are not finite"),
    ],
)
def test_wrong_weights_are_one_line(tmp_path: Path, changes: dict[str, Any], what: str) -> None:
    path = write_network(tmp_path / "wrong.onnx", **changes)
    with pytest.raises(InputError, match=rf"^.*wrong\.onnx: {what}.*; it must be .*$") as told:
        JointNetwork(path).propose(windows_of(0))
    assert "--proposals none" in str(told.value)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.99])
def test_weights_that_are_cut_short_are_one_line(tmp_path: Path, share: float) -> None:
    whole = write_network(tmp_path / "whole.onnx").read_bytes()
    path = tmp_path / "cut.onnx"
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match=r"^.*cut\.onnx: .*--proposals none.*$"):
        JointNetwork(path)


def test_weights_that_are_no_file_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.onnx: cannot be read.*--proposals none"):
        JointNetwork(tmp_path / "nowhere.onnx")
    with pytest.raises(InputError, match=r"no regular file.*--proposals none"):
        JointNetwork(tmp_path)


def test_weights_are_told_by_what_is_in_them(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    one, same = (write_network(folder / "w.onnx") for folder in (tmp_path, tmp_path / "a"))
    assert weights_as_json(one) == weights_as_json(same)
    assert weights_as_json(one)["name"] == "w.onnx"
    other = write_network(tmp_path / "a" / "w.onnx", constant=0.1)
    assert weights_as_json(one) != weights_as_json(other)


def test_a_mode_that_is_sure_of_its_joints_is_the_likelier_one() -> None:
    """By equal logits; the logits of all together change nothing."""
    logits = np.zeros((1, 2), np.float32)
    log_scales = np.full((1, 2, 21, 3), -3.0, np.float32)
    np.testing.assert_allclose(mode_weights(logits, log_scales), 0.5)
    log_scales[:, 1] += 0.1
    sure, unsure = mode_weights(logits, log_scales)[0]
    assert sure / unsure == pytest.approx(np.exp(COUNTED_SHARE * 0.1 * 63), rel=1e-4)
    np.testing.assert_allclose(mode_weights(logits + 7, log_scales + 1)[0], (sure, unsure))
    contrary = np.array([[0.0, 10.0]], np.float32)
    assert mode_weights(contrary, log_scales)[0].argmax() == 1


def test_nothing_is_said_on_the_way(tmp_path: Path) -> None:
    path = write_network(tmp_path / "w.onnx", nan_on_people=True)
    script = (
        "import sys; from pathlib import Path\n"
        "from topview.detect.joints.network import JointNetwork\n"
        "assert 'onnxruntime' not in sys.modules\n"
        f"JointNetwork(Path({str(path)!r}))"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert ended.stdout + ended.stderr == b""


def test_nobody_is_told_and_nothing_is_kept(tmp_path: Path) -> None:
    """onnxruntime's telemetry would begin with a file in the user's home."""
    script = (
        "from topview.detect.joints.network import JointNetwork\n"
        "JointNetwork()\n"
        "import os, sys\n"
        "assert 'onnxruntime' in sys.modules\n"
        "assert os.environ['ORT_DISABLE_TELEMETRY'] == '1'"
    )
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-c", script], env={**os.environ, **home}, check=True)
    assert not [path for path in tmp_path.rglob("*") if "onnxruntime" in path.name]
