"""Skin tones from very light to dark, and the light they are seen in."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview_lab.sim.appearance import Rgb

Lab = tuple[float, float, float]

SKIN_TONES: Final = MappingProxyType(
    {
        "very light": (70.0, 8.0, 13.5),
        "light": (66.0, 10.0, 15.5),
        "intermediate": (61.0, 11.5, 17.5),
        "tan": (54.0, 12.0, 19.0),
        "brown": (45.0, 12.0, 17.5),
        "dark": (34.0, 10.0, 13.0),
    }
)
"""CIELAB (L*, a*, b*) in the middle of each of the six classes of the individual typology angle
atan((L* - 50) / b*): A. Chardon, I. Cretois and C. Hourseau, Skin colour typology and suntanning
pathways (1991), classes as in S. Del Bino and F. Bernerd, Variations in skin colour and the
biological consequences of ultraviolet radiation exposure (2013). a* and b* are ours, within what
Y. Xiao et al., Characterising the variations in ethnic skin colours (2017), measured on faces."""
TONE_SPREAD: Final = (2.5, 2.0, 2.0)
"""Standard deviation of L*, a*, b* within a class (ours)."""
WARMTH_SPREAD: Final = 0.08
"""Standard deviation of the logarithm of what the white balance leaves to red and takes from
blue (ours); green varies by a third of it."""
EXPOSURES: Final = (0.4, 1.3)
"""Least and greatest exposure, of the simulator's own (ours)."""

JPEG_QUALITY: Final = 90
"""Of 100 (ours)."""

# CIE 1931, illuminant D65; IEC 61966-2-1.
_WHITE: Final = np.array([0.95047, 1.0, 1.08883])
_RGB_OF_XYZ: Final = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


def linear_rgb(lab: Lab) -> Rgb:
    """Linear sRGB in 0..1 of a CIELAB colour."""
    lightness, a, b = lab
    y = (lightness + 16.0) / 116.0
    f = np.array([y + a / 500.0, y, y - b / 200.0])
    xyz = _WHITE * np.where(f > 6 / 29, f**3, 3.0 * (6 / 29) ** 2 * (f - 4 / 29))
    red, green, blue = np.clip(_RGB_OF_XYZ @ xyz, 0.0, 1.0).tolist()
    return red, green, blue


def random_tone(name: str, rng: np.random.Generator) -> Rgb:
    """The linear colour of somebody of a class of `SKIN_TONES`."""
    lightness, a, b = (SKIN_TONES[name] + rng.normal(0.0, TONE_SPREAD)).tolist()
    return linear_rgb((lightness, a, b))


def relit(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A simulated image ([H, W, 3], gamma 2) in another exposure and white balance, and half of
    the time out of a JPEG file, which lets colours run."""
    warmth = rng.normal(0.0, WARMTH_SPREAD)
    gains = np.exp([warmth, rng.normal(0.0, WARMTH_SPREAD / 3.0), -warmth])
    gains = gains * np.exp(rng.uniform(*np.log(EXPOSURES)))
    levels = np.arange(256.0)[:, None] * np.sqrt(gains)
    table = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    lit = np.stack([table[rgb[..., c], c] for c in range(3)], axis=-1)
    if rng.random() < 0.5:
        return lit
    _, file = cv2.imencode(".jpg", lit[..., ::-1], (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY))
    decoded = np.asarray(cv2.imdecode(file, cv2.IMREAD_COLOR), np.uint8)
    return np.ascontiguousarray(decoded[..., ::-1])
