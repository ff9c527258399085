"""What a way to track bodies is: settings that make a tracker for each person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.filter.particles import generator
from topview.timing import StageClock
from topview.track.evidence import Evidence


class BodyPose(Protocol):
    """Where the parts of a body are."""

    def transforms(self, model: BodyModel) -> NDArray[np.float64]:
        """[11, 4, 4] `Ts_camera_part` of that body; NaN for parts that are not tracked."""
        ...


class BodyTracker(Protocol):
    """One person's body over time."""

    @property
    def model(self) -> BodyModel:
        """The body, of the size that is known so far."""
        ...

    def update(self, evidence: Evidence) -> BodyPose:
        """The pose in the next frame."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """Whom a body tracker follows, and what it may use for that.

    Attributes:
        person: id.
        seed: of every random number.
        threads: that the kernels may use; no result depends on it.
        clock: counts the time of each stage.
    """

    person: int
    seed: int
    threads: int
    clock: StageClock

    def rng(self, part: int, evidence: Evidence) -> np.random.Generator:
        """The random numbers of a part in a frame."""
        return generator(self.seed, self.person, part, evidence.frame_index)


@dataclass(frozen=True, slots=True)
class Needs:
    """What a method needs to be told of a person beside the points; computed for it alone.

    Attributes:
        hidden_share: `Evidence.hidden_share`.
        unowned_mask: `Evidence.unowned_mask`.
    """

    hidden_share: bool = False
    unowned_mask: bool = False


class BodyMethod(Protocol):
    """A way to track bodies: a frozen dataclass of its settings, plain JSON types or dataclasses.

    A new method is a file with such a class, and a line in `topview.track.methods`.

    Attributes:
        needs: what its trackers need.
    """

    needs: ClassVar[Needs]
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def name(self) -> str:
        """What `--method` calls it."""
        ...

    def tracker(self, subject: Subject) -> BodyTracker:
        """A tracker of somebody new."""
        ...
