"""Fig. 5.2: the hypotheses are what the thesis says of them."""

from __future__ import annotations

import pytest

from topview_lab.reproduce.cylinders import Observation
from topview_lab.reproduce.top_views import exemplars
from topview_lab.sim import SimulatedRecording, scene_by_name, simulate_truth


@pytest.fixture(scope="module")
def observation() -> Observation:
    recording = SimulatedRecording(scene_by_name("stand", seed=3, frames=1))
    return Observation.of(recording, simulate_truth(recording.scene), 0)


def test_only_f_align_tells_a_misaligned_torso_with_a_low_f_reproj(observation):
    right, high, misaligned = exemplars(observation)
    assert high.reproj > 2 * right.reproj
    assert misaligned.align > right.align  # its f_reproj is no greater: so it was chosen
    assert right.off_deg < high.off_deg
