"""One frame as the bodies are fitted in it, nearest first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.people.floor import FloorPlane
from topview.people.users import HandCandidate, User
from topview.track.evidence import Evidence, gather
from topview.track.pose import FittedBody


@dataclass(frozen=True, slots=True, eq=False)
class FittedScene:
    """A frame, whose its pixels are, and the bodies fitted so far.

    Attributes:
        image: the frame.
        labels: [H, W] id of the person that each pixel belongs to, 0 for nobody.
        floor: None where none is known.
        hands: where detectors that see colour take the hands to be, whosesoever they are.
        hidden_shares: how much of each person's image area nearer people hide, by id; empty where
            the method does not ask for it.
        bodies: nearest first.
    """

    image: Pyramid
    labels: NDArray[np.int32]
    floor: FloorPlane | None
    hands: tuple[HandCandidate, ...] = ()
    hidden_shares: Mapping[int, float] = field(default_factory=dict)
    bodies: tuple[FittedBody, ...] = ()

    def evidence_for(self, user: User, *, with_unowned_mask: bool = False) -> Evidence:
        """What the frame says about somebody, and the bodies that stand before."""
        evidence = gather(user, self.image, self.labels == user.id, self.floor)
        stride = evidence.stride
        return replace(
            evidence,
            hidden_share=self.hidden_shares.get(user.id, 0.0),
            unowned_mask=self.labels[::stride, ::stride] == 0 if with_unowned_mask else None,
            hands=self.hands,
            nearer_bodies=self.bodies,
        )

    def with_body(self, body: FittedBody) -> FittedScene:
        """The scene with one more body fitted."""
        return replace(self, bodies=(*self.bodies, body))
