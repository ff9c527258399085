"""The table of the body says what Sec. 3.2 says."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from topview.body.model import BodyModel
from topview.body.parts import HEAD, JOINT_NAMES, JOINTS, PART_NAMES, PARTS
from topview.body.proportions import ANATOMICAL, THESIS

PROPORTIONS = pytest.mark.parametrize(
    "proportions", [THESIS, ANATOMICAL], ids=["thesis", "anatomy"]
)
LIMBS = ("upper_arm", "forearm", "upper_leg", "lower_leg")


def test_eleven_parts_ten_articulations_22_degrees_of_freedom():
    articulated = [part for part in PARTS if part.parent >= 0]
    assert len(PARTS) == 11
    assert len(articulated) == 10
    assert sum(part.is_hinge for part in articulated) == 4
    assert sum(1 if part.is_hinge else 3 for part in articulated) == 22


def test_the_tree_hangs_from_the_head_and_parents_come_first():
    assert [part.name for part in PARTS if part.parent < 0] == [PARTS[HEAD].name]
    assert all(part.parent < index for index, part in enumerate(PARTS))
    children = {
        parent: {part.name for part in PARTS if part.parent == index}
        for index, parent in enumerate(PART_NAMES)
    }
    assert children["head"] == {"upper_torso"}
    assert children["upper_torso"] == {"lower_torso", "left_upper_arm", "right_upper_arm"}
    assert children["lower_torso"] == {"left_upper_leg", "right_upper_leg"}
    for side in ("left", "right"):
        assert children[f"{side}_upper_arm"] == {f"{side}_forearm"}
        assert children[f"{side}_upper_leg"] == {f"{side}_lower_leg"}


def test_names_are_unique_and_sides_come_in_pairs():
    for names in (PART_NAMES, JOINT_NAMES):
        assert len(set(names)) == len(names)
        for name in names:
            assert name.replace("left", "right") in names


def test_bones_lead_to_the_head_without_loops():
    for joint in JOINTS:
        seen = set()
        while joint.bone_to >= 0:
            assert joint.name not in seen
            seen.add(joint.name)
            joint = JOINTS[joint.bone_to]
        assert joint.name == "head"


@pytest.mark.parametrize(
    ("part", "axis", "degrees"),
    [
        ("upper_torso", 0, (-30, 60)),
        ("upper_torso", 2, (-45, 45)),
        ("lower_torso", 0, (-30, 45)),
        ("lower_torso", 1, (-30, 30)),
        ("left_upper_arm", 0, (-60, 180)),
        ("left_upper_arm", 2, (-10, 180)),
        ("left_upper_leg", 0, (-45, 100)),
        ("left_upper_leg", 2, (-10, 90)),
        ("left_forearm", 0, (-10, 160)),
        ("left_lower_leg", 0, (-100, 10)),
    ],
)
def test_limits_are_those_of_table_3_2(part, axis, degrees):
    limits = PARTS[PART_NAMES.index(part)].limits_rad
    assert_allclose(np.degrees(limits[axis]), degrees)


def test_limits_of_left_and_right_are_mirrored():
    for name, part in zip(PART_NAMES, PARTS, strict=True):
        other = PARTS[PART_NAMES.index(name.replace("left", "right"))]
        if other is not part:
            assert part.limits_rad[0] == other.limits_rad[0]
            for axis in (1, 2):
                low, high = part.limits_rad[axis]
                assert other.limits_rad[axis] == (-high, -low)


def test_five_hypotheses_of_torso_and_upper_legs_go_on_ten_of_the_others():
    """Sec. 6.1.3."""
    for part in PARTS:
        assert part.n_best == (5 if part.name.endswith(("torso", "upper_leg")) else 10)


@PROPORTIONS
def test_a_standing_body_is_as_tall_as_its_stature(proportions):
    p = proportions
    assert p.head + p.torso + p.upper_leg + p.lower_leg == pytest.approx(1.0)


def test_thesis_sizes_are_the_employed_ones_of_table_3_1():
    p = THESIS
    sizes = (p.head, p.upper_arm, p.forearm, p.torso, p.upper_leg, p.lower_leg)
    assert_allclose(sizes, (0.13, 0.18, 0.19, 0.38, 0.25, 0.24))
    assert 2 * (p.shoulder_half_breadth + p.upper_arm_radius) == pytest.approx(0.26, abs=0.001)


@PROPORTIONS
def test_bodies_scale_with_their_stature(proportions):
    small, tall = BodyModel.of(1.2, proportions), BodyModel.of(1.8, proportions)
    for name in ("lengths_m", "radii_m", "joints_parent", "joints_part"):
        assert_allclose(getattr(tall, name), 1.5 * getattr(small, name), atol=1e-12)


@PROPORTIONS
def test_left_and_right_are_mirrored_and_limbs_round(proportions):
    model = BodyModel.of(1.7, proportions)
    for index, name in enumerate(PART_NAMES):
        other = PART_NAMES.index(name.replace("left", "right"))
        assert model.lengths_m[index] == model.lengths_m[other]
        assert_array_equal(model.radii_m[index], model.radii_m[other])
        mirror = -1.0 if other != index else 1.0
        assert_allclose(model.joints_parent[index], model.joints_parent[other] * (mirror, 1, 1))
        if name.endswith(LIMBS):
            assert model.radii_m[index, 0] == model.radii_m[index, 1]
            assert model.radii_m[index, 0] < 0.5 * model.lengths_m[index]
