"""Whose body is known before the first frame, and what was learnt of everybody (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from topview.body.known_body import KnownBody
from topview.people.users import User

# Ours. A stature that was measured in one frame, so far from that of a known body, is another's.
STRANGER_M: Final = 0.15
LEARNT_S: Final = 1.0  # of whom less was seen, nothing is told


class KnownPeople:
    """Gives each new person the known body that fits, and their stature to whoever has one.

    Who is measured gets the body of the nearest stature, the best pair first; all others get what
    is left, in the order of the file. A body is one person's as long as that person is there.
    Whoever comes back has the same one, if nobody else has got it meanwhile.
    """

    def __init__(self, stature_m: float | None = None, bodies: Sequence[KnownBody] = ()) -> None:
        """
        Args:
            stature_m: of everybody; None if unknown.
            bodies: of those who may come; none if there is a stature of everybody.
        """
        self._stature_m = stature_m
        self._bodies = tuple(bodies)
        self._body_of: dict[int, int | None] = {}  # by id: an index, None for nobody known
        self._here: set[int] = set()  # ids of the last frame

    def body_of(self, person: int) -> KnownBody | None:
        """What is known of a person of the last frame."""
        index = self._body_of.get(person)
        return None if index is None else self._bodies[index]

    def stature_of(self, person: int) -> float | None:
        """What is known of the stature of a person of the last frame, metres; None for nothing."""
        body = self.body_of(person)
        return self._stature_m if body is None else body.stature_m

    def told(self, users: Sequence[User]) -> list[User]:
        """The people of the next frame, with the statures that are known."""
        if self._bodies:
            self._assign(users)
        return [self._with_stature(user) for user in users]

    def _with_stature(self, user: User) -> User:
        stature_m = self.stature_of(user.id)
        if stature_m is None:
            return user
        return replace(user, height_m=stature_m, height_is_measured=True)

    def _assign(self, users: Sequence[User]) -> None:
        """Find a body for whoever is new, and for whoever comes back and has lost theirs."""
        here = {user.id for user in users}
        held = {self._body_of.get(person) for person in here & self._here}
        for person in here - self._here:
            if self._body_of.get(person) in held:
                self._body_of.pop(person, None)
        self._here = here
        new = sorted((user for user in users if user.id not in self._body_of), key=lambda u: u.id)
        held = {self._body_of.get(user.id) for user in users}
        free = [index for index in range(len(self._bodies)) if index not in held]
        found = nearest_statures(
            {user.id: user.height_m for user in new if user.height_is_measured},
            {i: m for i in free if (m := self._bodies[i].stature_m) is not None},
        )
        left = [index for index in free if index not in found.values()]
        for user in new:
            index = found.get(user.id)
            if index is None:
                index = next((i for i in left if self._may_be(user, i)), None)
                left = [other for other in left if other != index]
            self._body_of[user.id] = index

    def _may_be(self, user: User, index: int) -> bool:
        """Whether nothing is known that tells a person from a body."""
        return not user.height_is_measured or self._bodies[index].stature_m is None


def nearest_statures(measured_m: dict[int, float], known_m: dict[int, float]) -> dict[int, int]:
    """Which known stature is whose: the nearest pair first; none that is `STRANGER_M` away."""
    apart = sorted(
        (abs(stature_m - own_m), person, index)
        for person, stature_m in measured_m.items()
        for index, own_m in known_m.items()
    )
    found: dict[int, int] = {}
    for apart_m, person, index in apart:
        if apart_m < STRANGER_M and person not in found and index not in found.values():
            found[person] = index
    return found


class LearntBodies:
    """What was learnt of everybody so far: of each the body that was followed for longest."""

    def __init__(self) -> None:
        self._of: dict[int, KnownBody] = {}

    def add(self, person: int, body: KnownBody) -> None:
        """What has been learnt of a person until now, or until they were lost."""
        before = self._of.get(person)
        if before is None or body.seconds >= before.seconds:
            self._of[person] = body

    def bodies(self) -> list[KnownBody]:
        """In the order of the ids; without those of whom too little was seen."""
        return [body for _, body in sorted(self._of.items()) if body.seconds >= LEARNT_S]
