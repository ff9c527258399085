"""Pictures of a training, where matplotlib is there to draw them: the losses, and whether the
network is as sure as it should be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from topview.files import naming
from topview_lab.training.joints.measuring import INTERVALS, JointScores

AXES: Final = ("to the right", "down", "along the ray")
_DOTS_PER_INCH: Final = 110


def draw_losses(rows: Sequence[Mapping[str, float]], path: Path) -> None:
    """The terms of the loss over the windows."""
    terms = [name for name in (rows[0] if rows else {}) if name != "windows"]
    thousands = [row["windows"] / 1000 for row in rows]

    def draw(place: int, axes: Any) -> None:
        axes.plot(thousands, [row[terms[place]] for row in rows])
        axes.set_title(terms[place], fontsize=9)
        axes.set_xlabel("thousand windows", fontsize=8)

    _draw(path, len(terms), draw)


def draw_reliability(scores: JointScores, path: Path) -> None:
    """How many of the intervals hold the truth that should, axis by axis, for joints in view and
    hidden by others."""

    def draw(place: int, axes: Any) -> None:
        axes.plot((0, 1), (0, 1), color="0.7", linewidth=1)
        for name, held in (("in view", scores.held_in_view), ("hidden", scores.held_hidden)):
            axes.plot(INTERVALS, held[:, place], marker=".", label=name)
        axes.set_title(AXES[place], fontsize=9)
        axes.set_xlabel("should hold", fontsize=8)
        axes.set_ylabel("hold", fontsize=8)
        axes.legend(fontsize=8)

    _draw(path, len(AXES), draw)


def _draw(path: Path, panels: int, draw: Callable[[int, Any], None]) -> None:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        return
    figure = Figure(figsize=(8, 2.6), layout="constrained")
    for place in range(panels):
        draw(place, figure.add_subplot(1, panels, place + 1))
    with naming(path, "written", "it must be a file that can be replaced"):
        FigureCanvasAgg(figure).print_figure(path, dpi=_DOTS_PER_INCH)
