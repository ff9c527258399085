"""Where limbs out of sight are is fitted to captured motion, by a command, and refused in one
line."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from made_captures import write_captures
from topview.body.parts import LEFT_UPPER_ARM, PARTS
from topview.files import read_archive
from topview.records import InputError
from topview.room.floor import CAMERA_UP
from topview.track.methods.topview.posture import Known
from topview.track.methods.topview.unseen_limbs import UnseenLimbs
from topview.track.pose import Pose, mirrored
from topview_lab.training.poses import read_captures
from topview_lab.training.unseen_limbs import FEWEST_CAPTURED, fit_unseen_limbs

LENGTHS = FEWEST_CAPTURED, 40


def chords(limbs: UnseenLimbs, Rs: np.ndarray) -> np.ndarray:
    """[F] from a left upper arm that is out of sight to where it is told; its forearm is seen."""
    seen = np.ones(len(PARTS))
    seen[LEFT_UPPER_ARM] = 0.0
    told = []
    for own in Rs:
        hanging = own.copy()
        hanging[LEFT_UPPER_ARM] = np.eye(3)
        pose = Pose(np.array([0.0, 0.0, 2.5]), hanging)
        told.append(limbs.told(pose, Known(seen, CAMERA_UP, None)).Rs[LEFT_UPPER_ARM, :, 1])
    return np.linalg.norm(np.array(told) - Rs[:, LEFT_UPPER_ARM, :, 1], axis=-1)


def lent(Rs: np.ndarray) -> np.ndarray:
    """Poses whose left upper arm points as the forearm does."""
    Rs = Rs.copy()
    Rs[:, LEFT_UPPER_ARM] = Rs[:, LEFT_UPPER_ARM + 1]
    return Rs


def test_what_captures_have_in_common_tells_of_other_people(tmp_path) -> None:
    Rs = read_captures(write_captures(tmp_path / "captures.npz", LENGTHS, sway_rad=0.8))
    alike, others = lent(Rs[:FEWEST_CAPTURED]), lent(Rs[FEWEST_CAPTURED:])
    without = fit_unseen_limbs(Rs[:FEWEST_CAPTURED], "arms and forearms at random")
    with_it = chords(fit_unseen_limbs(alike, "arms as their forearms"), others).mean()
    assert with_it < 0.7 * chords(without, others).mean()


def test_left_and_right_are_alike(tmp_path) -> None:
    Rs = read_captures(write_captures(tmp_path / "captures.npz", LENGTHS))
    one, other = fit_unseen_limbs(Rs, "made up"), fit_unseen_limbs(mirrored(Rs), "made up")
    assert_allclose(one.mean, other.mean, atol=1e-9)
    assert_allclose(one.covariance, other.covariance, atol=1e-9)


def test_too_few_poses_are_refused(tmp_path) -> None:
    Rs = read_captures(write_captures(tmp_path / "captures.npz"))
    with pytest.raises(InputError, match=f"60 captured poses .* at least {FEWEST_CAPTURED}"):
        fit_unseen_limbs(Rs, "made up")


def test_the_command_fits_and_writes(tmp_path, topview) -> None:
    captures, out = write_captures(tmp_path / "some.npz", LENGTHS), tmp_path / "limbs.npz"
    done = topview("train-unseen-limbs", captures, "--out", out, "--leave-out", "01_02")
    assert (done.status, done.complaints) == (0, [])
    arrays = read_archive(out)
    source = f"{FEWEST_CAPTURED} captured poses; topview train-unseen-limbs some.npz --leave-out"
    assert str(arrays.pop("source")) == f"{source} 01_02"
    wanted = fit_unseen_limbs(read_captures(captures, ["01_02"]), "")
    assert_allclose(UnseenLimbs("", **arrays).covariance, wanted.covariance)


def test_bad_input_is_one_line(tmp_path, topview) -> None:
    few, out = write_captures(tmp_path / "few.npz"), tmp_path / "limbs.npz"
    for arguments, said in (
        ((tmp_path / "none.npz", "--out", out), "none.npz: cannot be read"),
        ((few, "--out", out), "60 captured poses are too few"),
        ((few, "--out", out, "--leave-out", "09_09"), "has no capture 09_09"),
    ):
        refused = topview("train-unseen-limbs", *arguments)
        assert refused.status == 2
        assert said in refused.complaints[-1]
    assert not out.exists()
