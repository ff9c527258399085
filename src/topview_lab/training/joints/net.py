"""The network: a residual U-net from a window to joints, their scales, and what the window shows.

For each joint a heat map is spread over the window; where it is, how deep and how sure are means
under that map, so that a place is never tied to a pixel (integral regression: Sun et al., ECCV
2018). A body is proposed twice: as it is if it faces the camera, and as it is if it is turned away.

Whose pixels are whose is looked at coarsely. An outline as sharp as that of a rendered mask tells,
together with the readings that a sensor loses, on which side the hair is; no segmentation of a real
sensor's image does.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import VISIBLE_PIXELS
from topview.detect.joints.proposals import FACED_MODES
from topview.detect.joints.windows import DEPTH, OWN, WINDOW_PIXELS
from topview_lab.training.person_head import UNITS

PLACE, LOG_SCALES = slice(0, 3), slice(3, 6)
LOG_SCALE_RANGE = (-6.0, 0.5)  # of the box's half side: 3 mm to 2 m


@dataclass(frozen=True, slots=True)
class NetSettings:
    """Size of the network (ours).

    Attributes:
        widths: channels at 64, 32, 16 and 8 pixels a side.
        features: under a joint's heat map, from which its place and scales are told.
    """

    widths: tuple[int, int, int, int] = (16, 32, 80, 128)
    features: int = 64

    def as_json(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def from_json(settings: dict[str, Any]) -> NetSettings:
        """Inverse of `as_json`."""
        return NetSettings(**{**settings, "widths": tuple(settings["widths"])})


class Residual(nn.Module):
    """Two convolutions and a way round them."""

    def __init__(self, inside: int, outside: int, stride: int = 1) -> None:
        super().__init__()
        self.body = nn.Sequential(
            nn.Conv2d(inside, outside, 3, stride, 1, bias=False),
            nn.BatchNorm2d(outside),
            nn.ReLU(inplace=True),
            nn.Conv2d(outside, outside, 3, 1, 1, bias=False),
            nn.BatchNorm2d(outside),
        )
        self.way_round = nn.Sequential()
        if stride != 1 or inside != outside:
            self.way_round = nn.Sequential(
                nn.Conv2d(inside, outside, 1, stride, bias=False), nn.BatchNorm2d(outside)
            )

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(self.body(x) + self.way_round(x))


class PersonHead(nn.Module):
    """Whether a window shows a person: from how sure the network is of the joints in each mode, and
    from the means of what it sees at the coarsest. Neither alone tells who lies or bends from a
    piece of furniture, nor does their sum."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.hidden = nn.Linear(len(FACED_MODES) + features, UNITS)
        self.out = nn.Linear(UNITS, 1)

    def forward(self, log_scales: Tensor, means: Tensor) -> Tensor:
        """Logits [B] of [B, M, J, 3] and [B, C]."""
        # How sure of joints it is must not depend on what is said of it.
        sureness = log_scales.detach().mean(dim=(2, 3))
        return self.out(torch.tanh(self.hidden(torch.cat([sureness, means], dim=1)))).squeeze(1)


class JointNet(nn.Module):
    """From [B, 3, 128, 128] windows to what `topview.detect.joints.network` reads."""

    grid: Tensor

    def __init__(self, settings: NetSettings) -> None:
        super().__init__()
        self.settings = settings
        at_64, at_32, at_16, at_8 = settings.widths
        self.stem = nn.Sequential(
            nn.Conv2d(3, at_64, 5, 2, 2, bias=False), nn.BatchNorm2d(at_64), nn.ReLU(inplace=True)
        )
        self.down_32 = nn.Sequential(Residual(at_64, at_32, 2), Residual(at_32, at_32))
        self.down_16 = nn.Sequential(Residual(at_32, at_16, 2), Residual(at_16, at_16))
        self.down_8 = nn.Sequential(
            Residual(at_16, at_8, 2), Residual(at_8, at_8), Residual(at_8, at_8)
        )
        self.from_8 = nn.Sequential(nn.Conv2d(at_8, at_16, 1, bias=False), nn.BatchNorm2d(at_16))
        self.up_16 = Residual(at_16, at_16)
        self.from_16 = nn.Sequential(nn.Conv2d(at_16, at_32, 1, bias=False), nn.BatchNorm2d(at_32))
        self.up_32 = Residual(at_32, at_32)
        joints = len(FACED_MODES) * len(PROPOSED_JOINTS)
        self.heat = nn.Conv2d(at_32, joints, 1)
        self.features = nn.Sequential(
            nn.Conv2d(at_32, settings.features, 1, bias=False),
            nn.BatchNorm2d(settings.features),
            nn.ReLU(inplace=True),
        )
        self.weight = nn.Parameter(0.1 * torch.randn(joints, settings.features, 6) / 8.0)
        self.bias = nn.Parameter(torch.tensor([0.0] * 3 + [-2.0] * 3).repeat(joints, 1))
        self.visible = nn.Conv2d(at_32, 1, 1)
        self.modes = nn.Linear(at_8, len(FACED_MODES))
        self.person = PersonHead(at_8)
        places = (torch.arange(VISIBLE_PIXELS) + 0.5) * 2.0 / VISIBLE_PIXELS - 1.0
        down, right = torch.meshgrid(places, places, indexing="ij")
        self.register_buffer("grid", torch.stack([right, down]).reshape(2, -1), persistent=False)

    def forward(self, windows: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Places and log scales [B, M, 21, 3] in the box, logits of modes [B, M] and of a person
        [B], logits [B, 32, 32] of the person's visible pixels."""
        # Depth comes in steps of millimetres, which half precision would not tell apart.
        with torch.autocast(windows.device.type, enabled=False):
            at_64 = self.stem(_with_coarse_owners(windows))
        at_32 = self.down_32(at_64)
        at_16 = self.down_16(at_32)
        at_8 = self.down_8(at_16)
        means = at_8.mean(dim=(2, 3))
        up = self.from_8(at_8)
        up = functional.interpolate(up, scale_factor=2.0, mode="nearest")
        up = self.from_16(self.up_16(at_16 + up))
        up = functional.interpolate(up, scale_factor=2.0, mode="nearest")
        up = self.up_32(at_32 + up)
        M, J = len(FACED_MODES), len(PROPOSED_JOINTS)
        heat = torch.softmax(self.heat(up).flatten(2).float(), dim=2)
        features = self.features(up).flatten(2).float()
        with torch.autocast(windows.device.type, enabled=False):
            # What a 1 x 1 convolution says at each pixel, averaged under the map, is what it says
            # of the averaged features.
            middle = torch.matmul(heat, self.grid.T)
            under = torch.matmul(heat, features.transpose(1, 2))
            told = torch.matmul(under.transpose(0, 1), self.weight).transpose(0, 1) + self.bias
        places = told[..., PLACE] + functional.pad(middle, (0, 1))
        log_scales = told[..., LOG_SCALES].clamp(*LOG_SCALE_RANGE)
        log_scales = log_scales.reshape(-1, M, J, 3)
        return (
            places.reshape(-1, M, J, 3),
            log_scales,
            self.modes(means).float(),
            self.person(log_scales, means).float(),
            self.visible(up).float().squeeze(1),
        )


def _with_coarse_owners(windows: Tensor) -> Tensor:
    """[B, 3, 128, 128] windows whose depth is as it was, and whose owners are told no finer than
    the heat maps are."""
    cell = WINDOW_PIXELS // VISIBLE_PIXELS
    owners = functional.avg_pool2d(windows[:, OWN:], cell)
    owners = functional.avg_pool2d(owners, 3, 1, 1)
    owners = functional.interpolate(owners, scale_factor=float(cell), mode="nearest")
    return torch.cat([windows[:, DEPTH:OWN], owners], dim=1)
