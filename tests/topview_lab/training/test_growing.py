"""A larger network begins by saying what the smaller one says, and learns with all that it has."""

from __future__ import annotations

import pytest

pytest.importorskip("torch", reason="training needs the extra train")

import torch

from topview.records import InputError
from topview_lab.training.joints.growing import grown
from topview_lab.training.joints.net import JointNet, NetSettings

SMALL, LARGER = (8, 8, 16, 16), (8, 12, 16, 24)


@pytest.fixture
def small() -> JointNet:
    torch.manual_seed(0)
    return JointNet(NetSettings(SMALL, features=8)).eval()


def test_it_says_the_same_and_every_new_channel_can_learn(small: JointNet) -> None:
    larger = grown(small, LARGER).eval()
    assert larger.settings == NetSettings(LARGER, features=8)
    images = torch.rand(2, 3, 128, 128)
    for here, there in zip(small(images), larger(images), strict=True):
        torch.testing.assert_close(there, here, atol=1e-5, rtol=1e-5)
    optimizer = torch.optim.SGD(larger.parameters(), 0.1)
    for _ in range(2):  # what listens to a new channel learns first, then the channel itself
        optimizer.zero_grad()
        sum(out.square().mean() for out in larger.train()(images)).backward()  # pyright: ignore
        optimizer.step()
    new = larger.get_parameter("down_32.0.body.0.weight").grad
    assert new is not None
    assert (new[SMALL[1] :].abs().sum(dim=(1, 2, 3)) > 0.0).all()


def test_a_network_does_not_shrink(small: JointNet) -> None:
    with pytest.raises(InputError, match=r"--widths is 8 4 16 16; .* has 8 8 16 16"):
        grown(small, (8, 4, 16, 16))
