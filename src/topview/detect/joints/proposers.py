"""What can propose joints, by name; each is imported when it is first used."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Final, Literal

from topview import laboratory
from topview.detect.joints.proposals import JointProposer
from topview.records import InputError, shown

ProposalsName = Literal["network", "forest", "finder", "none"]
NETWORK: Final = "network"
FINDER: Final = "finder"
"""The network's, which tell the people finder alone who is there: no body is fitted to them."""
NOTHING: Final = "none"

# Name of each: what makes it, called without arguments, and a sentence about it.
PROPOSERS: Final[dict[str, tuple[str, str]]] = {
    NETWORK: (
        "topview.detect.joints.network:JointNetwork",
        "a network that has seen rendered people",
    ),
    **laboratory.RIVAL_PROPOSERS,
}
PROPOSALS: Final = (*PROPOSERS, FINDER, NOTHING)
OF_NETWORK: Final = (NETWORK, FINDER)
OF_NO_BODY: Final = (FINDER, NOTHING)


def check_proposals(name: str, weights: Path | None) -> None:
    """Refuse what names no proposals, and weights that nothing would read.

    Raises:
        InputError: it does.
    """
    if not isinstance(name, str) or name not in PROPOSALS:
        raise InputError(f"proposals is {shown(name)}; it must be one of {', '.join(PROPOSALS)}")
    if weights is not None and name not in OF_NETWORK:
        raise InputError(
            f"weights is {shown(str(weights))} with proposals {name}; weights are the network's"
        )


def proposer_by_name(name: str, weights: Path | None = None) -> JointProposer | None:
    """What proposes joints; None for "none".

    Args:
        name: one of `PROPOSALS`.
        weights: of the network; those of the project if None.

    Raises:
        InputError: there is no such thing, or the weights cannot be used.
    """
    check_proposals(name, weights)
    if name == NOTHING:
        return None
    is_network = name in OF_NETWORK
    module, _, attribute = PROPOSERS[NETWORK if is_network else name][0].partition(":")
    make = getattr(import_module(module), attribute)
    return make(weights) if is_network else make()


def proposals_as_json(name: str, weights: Path | None) -> dict[str, object]:
    """What proposals depend on, in JSON types.

    Raises:
        InputError: the weights cannot be read.
    """
    if name not in OF_NETWORK:
        return {"proposals": name}
    from topview.detect.joints.network import weights_as_json

    return {"proposals": name, "weights": weights_as_json(weights)}
