"""A larger network that says what a smaller one says, to go on learning from there.

New channels begin with weights of chance, and nothing that was there listens to them yet (after
Chen, Goodfellow, Shlens 2016, Net2Net).
"""

from __future__ import annotations

from dataclasses import replace

from topview.records import InputError
from topview_lab.training.joints.net import JointNet

LAYERS = "at 64, 32, 16 and 8 pixels a side"
MOST_CHANNELS = 1024


def grown(net: JointNet, widths: tuple[int, int, int, int]) -> JointNet:
    """A network with more channels.

    Args:
        net: the smaller one.
        widths: channels at 64, 32, 16 and 8 pixels a side, as many as in `net` or more.

    Raises:
        InputError: fewer channels than in `net`.
    """
    before = net.settings.widths
    if any(not least <= wide <= MOST_CHANNELS for least, wide in zip(before, widths, strict=True)):
        told, has = (" ".join(str(width) for width in own) for own in (widths, before))
        raise InputError(
            f"--widths is {told}; the network to go on from has {has} channels {LAYERS}, each may "
            f"be so many or more, up to {MOST_CHANNELS}"
        )
    larger = JointNet(replace(net.settings, widths=widths))
    state = larger.state_dict()
    for name, own in net.state_dict().items():
        new = state[name]
        if own.dim() > 1:
            new[: len(own), own.shape[1] :] = 0.0
        new[tuple(slice(size) for size in own.shape)] = own
    larger.load_state_dict(state)
    return larger
