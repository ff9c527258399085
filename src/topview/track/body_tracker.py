"""What a method is: settings that make a body tracker for each person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from topview.body.known_body import KnownBody
from topview.body.model import BodyModel
from topview.filter.particles import generator, time_key
from topview.timing import StageClock
from topview.track.bone_lengths import BoneLengths
from topview.track.evidence import Evidence
from topview.track.familiarity import Familiarity


class BodyPose(Protocol):
    """Where the parts of a body are."""

    def transforms(self, model: BodyModel) -> NDArray[np.float64]:
        """[11, 4, 4] `Ts_camera_part` of that body; NaN for parts that are not tracked."""
        ...


class BodyTracker(Protocol):
    """Tracks one person's body from frame to frame."""

    @property
    def model(self) -> BodyModel:
        """The body model, of the stature that is known so far."""
        ...

    def update(self, evidence: Evidence) -> BodyPose:
        """The pose in the next frame."""
        ...


@runtime_checkable
class LearnsBones(Protocol):
    """A body tracker that learns how long the bones are."""

    @property
    def bones(self) -> BoneLengths:
        """As far as they are known."""
        ...


@runtime_checkable
class KnowsFamiliarity(Protocol):
    """A body tracker that knows how far proposed joints can be relied on."""

    @property
    def familiarity(self) -> Familiarity:
        """Of the last frame with proposals."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """Whose body a tracker tracks, and what it may use for that.

    Attributes:
        person: the id.
        seed: of every random number.
        threads: for the kernels, 1 or more; no result depends on it.
        clock: counts the time of each stage.
        known: the person's body, known beforehand; None if it is not.
        stature_is_given: whether the stature is known beforehand.
    """

    person: int
    seed: int
    threads: int
    clock: StageClock
    known: KnownBody | None = None
    stature_is_given: bool = False

    @property
    def bones(self) -> BoneLengths:
        """The person's bones before the first frame."""
        return BoneLengths(None if self.known is None else self.known.bones)

    def rng(self, part: int, evidence: Evidence) -> np.random.Generator:
        """The random generator for a part in one frame."""
        return generator(self.seed, self.person, part, time_key(evidence.timestamp_s))


@dataclass(frozen=True, slots=True)
class Needs:
    """Optional parts of `Evidence` that a method needs; they are computed only then.

    Attributes:
        hidden_share: `Evidence.hidden_share`.
        unowned_mask: `Evidence.unowned_mask`.
        joints: `Evidence.proposals`.
        joints_only: those, and without them the method can do nothing.
    """

    hidden_share: bool = False
    unowned_mask: bool = False
    joints: bool = False
    joints_only: bool = False


class BodyMethod(Protocol):
    """A method of tracking bodies: a frozen dataclass of its settings.

    The settings are plain JSON types, or dataclasses of them.

    A new method is one file with such a class, and one line in `topview.track.methods`.

    Attributes:
        needs: what its trackers need.
    """

    needs: ClassVar[Needs]
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def name(self) -> str:
        """The method's name, as `--method` takes it."""
        ...

    def tracker(self, subject: Subject) -> BodyTracker:
        """A tracker for a new person."""
        ...
