"""Plots of the report, drawn by matplotlib (extra `report`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from topview.records import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OVERALL_COLOR: Final = "#1f6fb2"
OCCLUDED_COLOR: Final = "#c8402f"
"""Blue and red as in Fig. 6.3."""

IN_COLOR: Final = "#009e73"
OUT_COLOR: Final = "#d55e00"
HIDDEN_COLOR: Final = "#0072b2"
"""Green, red and blue as in Fig. 5.7, of the palette of Okabe and Ito."""
POINTS_COLOR: Final = "#a9b1bd"
SUBJECT_COLOR: Final = "#7fa3c7"
OUTLINE_COLOR: Final = "#1d2330"

PLOT_STYLE: Final[dict[Any, Any]] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "figure.dpi": 110,
    "font.size": 9,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "savefig.bbox": "tight",
}


def require_matplotlib() -> None:
    """Raises InputError where it is not installed."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise InputError(
            "the report's plots need matplotlib; install it with: pip install 'topview[report]'"
        ) from error


@contextmanager
def drawn(path: Path, rows: int, columns: int, size: tuple[float, float]) -> Iterator[Any]:
    """Axes [rows, columns] of a new figure, each `size` inches, saved to `path` at the end."""
    with figure(path, (columns * size[0], rows * size[1])) as fig:
        yield fig.subplots(rows, columns, squeeze=False)
        fig.tight_layout()


@contextmanager
def figure(path: Path, size: tuple[float, float]) -> Iterator[Figure]:
    """A new figure of `size` inches, saved to `path` at the end; needs no display."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(PLOT_STYLE):
        fig = Figure(figsize=size)
        FigureCanvasAgg(fig)
        yield fig
        path.parent.mkdir(parents=True, exist_ok=True)
        fig.savefig(path, metadata={"Software": None})
