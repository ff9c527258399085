"""One frame while the bodies in it are fitted, nearest first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.joints.proposals import JointProposals
from topview.people.users import HandCandidate, User
from topview.room.floor import FloorPlane
from topview.track.evidence import Evidence, gather
from topview.track.pose import FittedBody


@dataclass(frozen=True, slots=True, eq=False)
class FittedScene:
    """A frame, its label image, and the bodies fitted so far.

    Attributes:
        image: the frame.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        floor: None where none is known.
        hands: candidates from colour, of any person.
        hidden_shares: share of each person's image area that nearer people hide, by id; empty for
            methods that do not need it.
        bodies: fitted so far, nearest first.
        proposals: of each person's joints, by id, for those of whom something is proposed.
    """

    image: Pyramid
    labels: NDArray[np.int32]
    floor: FloorPlane | None
    hands: tuple[HandCandidate, ...] = ()
    hidden_shares: Mapping[int, float] = field(default_factory=dict)
    bodies: tuple[FittedBody, ...] = ()
    proposals: Mapping[int, JointProposals] = field(default_factory=dict)

    def evidence_for(self, user: User, *, with_unowned_mask: bool = False) -> Evidence:
        """What the frame shows of a user, and the nearer bodies."""
        return gather(
            user,
            self.image,
            self.labels,
            self.floor,
            with_unowned_mask=with_unowned_mask,
            hidden_share=self.hidden_shares.get(user.id, 0.0),
            hands=self.hands,
            nearer_bodies=self.bodies,
            proposals=self.proposals.get(user.id),
        )

    def with_body(self, body: FittedBody) -> FittedScene:
        """The scene with one more body fitted."""
        return replace(self, bodies=(*self.bodies, body))
