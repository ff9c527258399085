"""The tracker treats left and right alike, as far as random numbers and the pixel grid allow.

Bounds stand some 40 % over the largest of what seeds 0, 1 and 2 gave when they were set, and hold
over the joints of all three; `topview evaluate mirror` measures whole recordings.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

import topview
from excerpts import Excerpt
from topview.track.settings import TrackerSettings
from topview_lab.evaluate.mirror import compare_with_mirror_image
from topview_lab.metrics.mirror import pooled_apart
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.scenes import KINECT_V1_HALF

SETTINGS = TrackerSettings(threads=1)
FRAMES = 25

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("width", "proposals", "median_cm", "most_cm"),
    [
        # Every second or fourth column from 0 on is the same choice from the other side. 0.70 to
        # 0.84 cm (median), 2.2 to 2.4 cm (95 %): arms, which random numbers propose and usual
        # poses draw away again. Before sizes were learnt 0.65 to 0.85 and 4.2 to 4.6 cm, before
        # steps uphill were taken back 0.57 to 0.58 and 3.8 to 4.6 cm, where another seed gave 0.3
        # to 0.4 and 3.0 to 4.3 cm; before usual poses 0.32 to 0.54 and 1.0 to 2.6 cm.
        pytest.param(313, "none", 0.8, 6.6, id="columns that mirror"),
        # From the other side the odd columns are looked at: 1.07 to 1.25 cm, 3.0 to 3.4 cm. Before
        # sizes were learnt 1.01 to 1.12 and 3.9 to 5.2 cm, before that 1.04 to 1.19 and 4.5 to 6.0
        # cm, where another seed gave 0.5 and 4.4 to 5.6 cm.
        pytest.param(320, "none", 1.5, 8.4, id="columns that do not"),
        # The network sees the same of both, and nothing is random: 0.13 cm, 0.46 cm (0.15 and 0.57
        # cm before proposed joints counted less where windows look unfamiliar).
        pytest.param(313, "network", 0.22, 0.77, id="with the network"),
    ],
)
def test_two_people_of_the_simulator(width, proposals, median_cm, most_cm):
    camera = replace(KINECT_V1_HALF, width=width)
    scene = scene_by_name("two_users", seed=5, frames=FRAMES, camera=camera)
    settings = replace(SETTINGS, proposals=proposals)
    recording = Excerpt(SimulatedRecording(scene), FRAMES)
    seeds = range(3) if proposals == "none" else [0]  # nothing is random with the network
    aparts = [compare_with_mirror_image(recording, replace(settings, seed=s)) for s in seeds]
    assert all(len(apart.distances_cm) == 2 * FRAMES for apart in aparts)
    apart = pooled_apart(aparts)
    assert apart.alone == 0
    assert apart.quantile_cm(0.5) < median_cm
    assert apart.quantile_cm(0.95) < most_cm


def test_somebody_of_another_renderer(shared):
    """0.31 cm (median), 1.1 cm (95 %)."""
    folder = shared / "bench" / "b1_pass_by"
    if not folder.exists():
        pytest.skip(f"needs {folder}, which is not part of the project")
    apart = compare_with_mirror_image(Excerpt(topview.open(folder), 60), SETTINGS)
    assert apart.quantile_cm(0.5) < 0.35
    assert apart.quantile_cm(0.95) < 1.4
