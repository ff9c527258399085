"""Does a GPU count what the CPU counts for the uTVR score, and how long does each take?

    python scripts/measure_cuda.py [--sizes 320x240,640x480] [--hypotheses 64,256,1024,4096]
        [--once]

Scores hypotheses of a thigh before a rough wall 2 m away, with three parts placed beside it, on one
CPU thread and on a GPU (numba-cuda or numba's own CUDA target; with NUMBA_ENABLE_CUDASIM=1 in the
simulator, whose times mean nothing). The images stay on the GPU; hypotheses go there and counts
come back in the time that is told. A GPU multiplies and adds in one rounding, so that a point on a
border may fall on the other side: exit status 1 where a count differs by more than one in a
thousand, and one more, or where none is above zero.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from topview.geometry.rotations import rotations_from_angles
from topview.kernels.threads import use_threads
from topview.kernels.utvr import N_COUNTS
from topview.kernels.utvr import count_hypotheses as count_on_cpu
from topview.score.utvr import placed_parts
from topview_lab.bench.inner_loops import KERNEL_RUNS, median_ms
from topview_lab.kernels.utvr_cuda import count_hypotheses as count_on_gpu
from topview_lab.kernels.utvr_cuda import cuda

THREADS = 128  # of a block
MOST_APART = 1e-3
LENGTH_M, RADII_M, DISTANCE_M = 0.4, (0.08, 0.07), 2.0
FOCAL_LENGTHS = 0.9  # of the image's width

Counts = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """What is counted: the images, what goes with each call, and the rest of the arguments."""

    images: tuple[NDArray[np.float32], NDArray[np.uint8]]
    intrinsics: tuple[np.float32, ...]
    hypotheses: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint8]]
    sizes: tuple[np.float32, ...]
    placed: NDArray[np.float32]

    @classmethod
    def of(cls, width: int, height: int, count: int) -> Work:
        """Always the same for one size and number."""
        rng = np.random.default_rng(count)
        fx = np.float32(FOCAL_LENGTHS * width)
        depth = DISTANCE_M + 0.05 * rng.standard_normal((height, width))
        depth[rng.random((height, width)) < 0.05] = 0.0  # no reading
        own = (rng.random((height, width)) < 0.9).astype(np.uint8)
        Rs = rotations_from_angles(0.5 * rng.standard_normal((count, 3)))
        origins = np.array([0.0, -LENGTH_M / 2, DISTANCE_M])
        origins = origins + 0.1 * rng.standard_normal((count, 3))
        beside = np.array([[-0.1, 0.0, DISTANCE_M], [0.1, 0.0, DISTANCE_M], [0.0, 0.2, DISTANCE_M]])
        placed = placed_parts(Rs[:3], beside, np.full(3, LENGTH_M), np.full((3, 2), 0.08))
        return cls(
            (depth.astype(np.float32), own),
            (fx, fx, np.float32((width - 1) / 2), np.float32((height - 1) / 2)),
            (Rs.astype(np.float32), origins.astype(np.float32), np.ones(count, np.uint8)),
            tuple(np.array([LENGTH_M, *RADII_M, 2.0 * DISTANCE_M / fx, 0.05], np.float32)),
            placed,
        )

    def on_cpu(self) -> Counts:
        """[M, 7], by one thread."""
        out = np.empty((len(self.hypotheses[0]), N_COUNTS), np.int32)
        count_on_cpu(
            *self.images, *self.intrinsics, *self.hypotheses, *self.sizes, self.placed, 1, out
        )
        return out

    def on_gpu(self) -> Callable[[], Counts]:
        """What gives [M, 7] there, with the images and placed parts there already."""
        images, placed = [cuda.to_device(own) for own in self.images], cuda.to_device(self.placed)
        count = len(self.hypotheses[0])
        out = cuda.device_array((count, N_COUNTS), np.int32)

        def counts() -> Counts:
            hypotheses = [cuda.to_device(own) for own in self.hypotheses]
            count_on_gpu[count, THREADS](
                *images, *self.intrinsics, *hypotheses, *self.sizes, placed, out
            )
            return out.copy_to_host()

        return counts


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--sizes", default="320x240,640x480")
    parser.add_argument("--hypotheses", default="64,256,1024,4096")
    parser.add_argument("--once", action="store_true", help=f"one timed call, not {KERNEL_RUNS}")
    options = parser.parse_args()
    runs = 1 if options.once else KERNEL_RUNS
    use_threads(1)
    table = Table("image", "hypotheses", "one CPU thread, ms", "GPU, ms", "counts that differ")
    is_same = True
    for size in options.sizes.split(","):
        width, height = map(int, size.split("x"))
        for count in map(int, options.hypotheses.split(",")):
            work = Work.of(width, height, count)
            on_gpu = work.on_gpu()
            expected, counted = work.on_cpu(), on_gpu()
            apart = np.abs(counted - expected)
            is_same &= bool((apart <= 1 + MOST_APART * expected).all())
            is_same &= bool((expected.max(axis=0) > 0).all())
            times = (f"{median_ms(call, runs):.2f}" for call in (work.on_cpu, on_gpu))
            differing = f"{(apart > 0).sum()} of {apart.size}, by {apart.max()} at most"
            table.add_row(size, str(count), *times, differing)
    Console(width=100).print(table)
    return 0 if is_same else 1


if __name__ == "__main__":
    raise SystemExit(main())
