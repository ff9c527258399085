"""The settings of detectors: their ranges, and that they reach what they set."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
import pytest

from detect_scenes import SKIN_RGB, frame_of
from topview.detect.cloud import Cloud
from topview.detect.detectors import DepthAndSkinHeads, SkinHeads
from topview.detect.heads import NO_HINTS, DepthHeadDetector
from topview.detect.skin import BackgroundName, SkinSettings
from topview.records import InputError
from topview.timing import StageClock

UP = np.array([0.0, -1.0, 0.0])


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda: SkinSettings(seed_probability=1.1), "seed_probability is 1.1; it must be 0 to 1"),
        (lambda: SkinSettings(0.5, 0.6), "growth_probability is 0.6; it must be 0 to 0.5"),
        (lambda: SkinSettings(0.5, -0.1), "growth_probability is -0.1; it must be 0 to 0.5"),
        (
            lambda: SkinSettings(background=cast(BackgroundName, "none")),
            "background is 'none'; it must be one of still, mixtures, colors",
        ),
        (lambda: DepthHeadDetector(2.0), "min_confidence is 2.0; it must be 0 to 1"),
        (lambda: DepthHeadDetector(max_depth_m=0.0), "max_depth_m is 0.0; it must be 0.5 to 100"),
    ],
)
def test_what_is_out_of_range_is_refused_in_one_line(
    make: Callable[[], object], complaint: str
) -> None:
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value) == complaint


@pytest.mark.parametrize("kind", [SkinHeads, DepthAndSkinHeads])
def test_thresholds_of_skin_reach_the_search_for_it(kind: type[SkinHeads]) -> None:
    cloud = Cloud.from_frame(frame_of([(60, 60, 12, 2.0, SKIN_RGB)]))
    regions = []
    for settings in (None, SkinSettings(seed_probability=1.0)):
        detector = kind(StageClock(), settings)
        detector.faces(cloud, NO_HINTS)
        assert detector.skin_detections is not None
        regions.append(len(detector.skin_detections.blobs))
    assert regions == [1, 0]
