"""How the tracker is steered: one frozen record, from which the command line is made."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from topview.body.known_body import bodies_as_json, check_stature
from topview.detect.detectors import DETECTORS, DetectorName
from topview.detect.joints.proposers import (
    FINDER,
    NETWORK,
    ProposalsName,
    check_proposals,
    proposals_as_json,
)
from topview.people.settings import PeopleSettings
from topview.records import InputError, check_range, real_number, shown, whole_number
from topview.room.areas import Areas
from topview.track.body_tracker import Needs
from topview.track.methods import DEFAULT, method_by_name, method_name

MOST_SMOOTHING_S: Final = 2.0  # ours; a longer memory tells of another moment


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """What a user can choose.

    Attributes:
        method: how bodies are tracked: "topview" is the full tracker; "utvr" is the thesis's own
            recipe (Sec. 5.3), greedy from the head down, without what this project adds to it
            ("thesis" is another word for it); "btvr" tracks the upper body alone (Sec. 5.1), and
            leaves the legs absent; "joints" fits a body to the joints that the network proposes,
            each frame on its own. To compare with: "bpso" and "ppso" are particle swarms over the
            whole body, baseline and perturbed; "forest" has learnt what body parts look like, and
            remembers nothing from frame to frame; "ellipsoids" fits them to the silhouette's points
            (Sec. 2.2), of the upper body alone.
        detector: how people's heads are found: "auto" by depth and, where nothing proposes joints
            and the recording allows, the colour of skin; "depth", "skin" (Sec. 4.1) and "cascade"
            (frontal faces) by that alone.
        seed: of every random number; the same recording and seed give bit-identical output.
        threads: for the kernels, 0 for all cores; the output does not depend on it.
        proposals: what proposes joints to the methods that ask for it: "network" has seen rendered
            people, "forest" is a rival's; "finder" has the network tell the people finder alone who
            is there, with any method, and "none" leaves both alone.
        people: at most so many are tracked at the same time; not given, any number.
        region: people are looked for here only: corners of a polygon in the image, in pixels, like
            "0,0 320,0 320,200", or a box on the floor, in metres to the right and ahead of the
            camera, like "floor -1,1 1,4"; several are separated by ";".
        ignore: people are not looked for here; written like `region`.
        reidentify: whoever left and comes back gets the number of before, by the colours of the
            clothes and by stature, if these tell clearly; whoever else wears the same may get it,
            too.
        weights: file of the network's weights, as `topview train-joints` writes it; not given,
            those that come with the project.
        moving_camera: go on where the camera moves; not given, that ends the tracking with an
            error, as the room, the floor and who is who are known only where it stands still.
        smoothing_s: memory of the mean that each body is smoothed by, seconds: the longest delay of
            what moves slowly; what moves faster lags less, below 5 cm and 9 degrees. 0 leaves
            bodies as they are.
        stature: of everybody, metres, 0.5 to 2.5; not given, it is measured of whoever stands
            upright.
        body: file of the bodies that `--save-body` learnt, or that you wrote: who they are of is
            told by stature, else by the order in which they come.

    Raises:
        InputError: a method, detector or proposals that do not exist, weights that nothing would
            read, a seed or number of threads or people that is no whole number, a number out of
            range, an area that is none, a stature beside a file of bodies.
    """

    method: str = DEFAULT
    detector: DetectorName = "auto"
    seed: int = 0
    threads: int = 0
    proposals: ProposalsName = NETWORK
    weights: Path | None = None
    people: int | None = None
    reidentify: bool = False
    region: str = ""
    ignore: str = ""
    moving_camera: bool = False
    smoothing_s: float = 0.0
    stature: float | None = None
    body: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "method", method_name(self.method))
        if not isinstance(self.detector, str) or self.detector not in DETECTORS:
            known = ", ".join(DETECTORS)
            raise InputError(f"detector is {shown(self.detector)}; it must be one of {known}")
        for name in ("threads", "seed"):
            object.__setattr__(self, name, whole_number(getattr(self, name), name))
        if self.threads < 0:
            raise InputError(f"threads is {shown(self.threads)}; it must be 0 (all cores) or more")
        if not 0 <= self.seed < 2**63:
            raise InputError(f"seed is {shown(self.seed)}; it must be 0 to 2^63 - 1")
        if self.people is not None:
            object.__setattr__(self, "people", whole_number(self.people, "people"))
            if self.people < 1:
                raise InputError(f"people is {shown(self.people)}; it must be 1 or more")
        Areas.told(self.region, self.ignore)
        check_range(self, 0.0, MOST_SMOOTHING_S, "smoothing_s")
        if self.stature is not None:
            object.__setattr__(self, "stature", real_number(self.stature, "stature"))
            check_stature(self.stature, "stature")
        if self.body is not None:
            object.__setattr__(self, "body", Path(self.body))
            if self.stature is not None:
                raise InputError(
                    f"stature is {shown(self.stature)} beside body {shown(str(self.body))}; "
                    "give one of them: the file tells statures, too"
                )
        if self.weights is not None:
            object.__setattr__(self, "weights", Path(self.weights))
        check_proposals(self.proposals, self.weights)

    def finding_with(self, *, proposes: bool) -> PeopleSettings:
        """How people are found; `proposes`: whether something proposes joints."""
        detector = "depth" if proposes and self.detector == "auto" else self.detector
        areas = Areas.told(self.region, self.ignore)
        return PeopleSettings(
            detector=detector, people=self.people, reidentify=self.reidentify, areas=areas
        )

    def as_json(self, needs: Needs | None = None) -> dict[str, Any]:
        """Plain JSON types, for the outputs: all that they depend on, so not the threads, and of
        the weights and the bodies their file's name and digest.

        Args:
            needs: of the method; None for those of the one that `method` names.

        Raises:
            InputError: the weights, or the bodies, cannot be read.
        """
        named: dict[str, Any] = {
            "method": self.method, "detector": self.detector, "seed": self.seed,
        }  # fmt: skip
        chosen = {
            "people": self.people, "reidentify": self.reidentify,
            "region": self.region, "ignore": self.ignore,
            "moving_camera": self.moving_camera,
        }  # fmt: skip
        named |= {name: value for name, value in chosen.items() if value}
        needs = needs or method_by_name(self.method).needs
        if needs.joints or self.proposals == FINDER:
            named |= proposals_as_json(self.proposals, self.weights)
        if self.smoothing_s > 0.0:
            named["smoothing_s"] = self.smoothing_s
        if self.stature is not None:
            named["stature"] = self.stature
        if self.body is not None:
            named["bodies"] = bodies_as_json(self.body)
        return named
