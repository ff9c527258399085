"""Wrists and feet are measured as all joints are, and are in no other table."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from rich.console import Console

from skeleton_sequences import people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES, OUTPUT_JOINT_NAMES
from topview.body.parts import END_NAMES
from topview.skeletons import SkeletonSequence
from topview_lab.evaluate.report import print_summary
from topview_lab.metrics import ReferenceSequence, Summary, evaluate_sequence, summarise
from topview_lab.metrics.samples import CAUSES

FRAMES = 4
BODIES = people_standing(FRAMES, 0.0, 2.0)
RNG = np.random.default_rng(4)
ENDS = BODIES[:, :, :1] + RNG.normal(0.0, 0.3, (FRAMES, 2, len(END_NAMES), 3))
HIDDEN = np.zeros((FRAMES, 2, len(OUTPUT_JOINT_NAMES)))
HIDDEN[:2, :, OUTPUT_JOINT_NAMES.index("left_foot")] = 0.8


def reference(with_ends: bool) -> ReferenceSequence:
    if not with_ends:
        shares = HIDDEN[:, :, : len(JOINT_NAMES)].copy()
        return reference_of(BODIES, occluded_by_person=shares)
    joints = np.concatenate([BODIES, ENDS], axis=2)
    names = OUTPUT_JOINT_NAMES
    return reference_of(joints, joint_names=names, occluded_by_person=HIDDEN.copy())


def predicted(ends: np.ndarray) -> SkeletonSequence:
    body = predicted_of(BODIES + RNG.normal(0.0, 0.02, BODIES.shape))
    shape = (*BODIES.shape[:2], len(END_NAMES))
    return replace(
        body,
        joint_names=OUTPUT_JOINT_NAMES,
        joints_camera=np.concatenate([body.joints_camera, ends], axis=2),
        joint_state=np.concatenate([body.joint_state, np.ones(shape, np.uint8)], axis=2),
        joint_confidence=np.concatenate(
            [body.joint_confidence, np.full(shape, 0.1, np.float32)], axis=2
        ),
        joint_covariance_m2=np.concatenate(
            [body.joint_covariance_m2, np.full((*shape, 3, 3), np.nan, np.float32)], axis=2
        ),
    )


def measured(sequence: SkeletonSequence, truth: ReferenceSequence) -> Summary:
    return summarise(evaluate_sequence(sequence, truth))


def without_ends(summary: Summary) -> bytes:
    return msgspec.json.encode(replace(summary, ends_cm={}))


def test_they_have_rows_of_their_own_and_change_no_other():
    off = ENDS.copy()
    off[..., END_NAMES.index("left_foot"), 2] += [[0.03], [0.05], [0.03], [0.05]]
    sequence = predicted(off)
    with_them = measured(sequence, reference(with_ends=True))
    rows = with_them.ends_cm["all"]
    assert [*rows] == [*END_NAMES, "all"]
    assert rows["left_foot"].raw.mean == pytest.approx(4.0)
    assert rows["left_foot"].offset_out.mean == pytest.approx(1.0)
    assert rows["right_wrist"].raw.mean == 0.0
    hidden = with_them.ends_cm[f"hidden by {CAUSES[0]} ≥ 60%"]
    assert (hidden["left_foot"].raw.count, hidden["right_foot"].raw.count) == (4, 0)
    # A sequence without them, and one whose wrists and feet are nowhere near: the same elsewhere.
    body = replace(
        sequence,
        joint_names=JOINT_NAMES,
        joints_camera=sequence.joints_camera[:, :, :16].copy(),
        joint_state=sequence.joint_state[:, :, :16].copy(),
        joint_confidence=sequence.joint_confidence[:, :, :16].copy(),
        joint_covariance_m2=sequence.joint_covariance_m2[:, :, :16].copy(),
    )
    alone = measured(body, reference(with_ends=False))
    assert alone.ends_cm == {}
    assert without_ends(with_them) == without_ends(alone)
    far_camera = sequence.joints_camera.copy()
    far_camera[:, :, len(JOINT_NAMES) :] += 5.0
    away = replace(sequence, joints_camera=far_camera)
    assert without_ends(measured(away, reference(with_ends=True))) == without_ends(alone)


@pytest.mark.parametrize("detail", [False, True])
def test_only_the_detailed_report_tells_of_them(detail):
    console = Console(width=100)
    with console.capture() as told:
        summary = measured(predicted(ENDS), reference(with_ends=True))
        print_summary(summary, console, "made", detail=detail)
    assert ("left_wrist" in told.get()) == detail
    assert "left_hand" in told.get()
