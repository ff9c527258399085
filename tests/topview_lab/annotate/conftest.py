"""A short simulated two-camera recording of somebody with markers, shared by all tests here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from numpy.typing import NDArray

from topview.camera.projection import project
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.landmarks import NAMES
from topview_lab.annotate.server import AnnotationServer
from topview_lab.annotate.session import Session
from topview_lab.sim.markers import marker_scenes, write_marker_scenes
from topview_lab.sim.scenes import KINECT_V1_FULL

FRAMES = 36  # the arm goes up from the 12th on


@dataclass(frozen=True)
class Marked:
    """The two recordings and their truth."""

    front: Path
    rear: Path
    T_front_rear: NDArray[np.float64]
    joints: NDArray[np.float64]
    """[F, 1, J, 3] in the order of the landmarks."""
    markers: NDArray[np.float64]
    """[F, 1, J, 2, 3] metres in the front camera's frame."""

    def pixel(self, joint: str, frame: int = 0) -> tuple[float, float]:
        """Of a joint's front marker in the front view."""
        u, v = project(self.markers[frame, 0, NAMES.index(joint), 0], KINECT_V1_FULL)
        return float(u), float(v)


def simulate_marked(folder: Path, frames: int, seed: int = 0) -> Marked:
    front, rear = marker_scenes(seed=seed, frames=frames)
    write_marker_scenes(front, rear, folder)
    truth = np.load(folder / "truth.npz")
    names, marked = truth["names"].tolist(), truth["marker_joints"].tolist()
    return Marked(
        folder / "front",
        folder / "rear",
        truth["T_front_rear"],
        truth["joints"][:, :1, [names.index(name) for name in NAMES]].astype(np.float64),
        truth["markers"][:, :, [marked.index(name) for name in NAMES]],
    )


@pytest.fixture(scope="session")
def marked(tmp_path_factory: pytest.TempPathFactory) -> Marked:
    return simulate_marked(tmp_path_factory.mktemp("marked"), FRAMES)


@pytest.fixture(scope="session")
def found_folder(marked: Marked, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a project in which everything is found and nothing changed; do not write."""
    out = tmp_path_factory.mktemp("found")
    with Session(marked.front, marked.rear, out, FindOptions()) as session:
        session.pick(0, 0, *marked.pixel("torso"), add=False)
        session.run(lambda doing, done, total: None)
    return out


@pytest.fixture
def session(marked: Marked, found_folder: Path, tmp_path: Path) -> Iterator[Session]:
    """With everything found, in a folder of its own."""
    for file in found_folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    with Session(marked.front, marked.rear, tmp_path, FindOptions()) as session:
        yield session


@pytest.fixture
def serve() -> Iterator[object]:
    """Starts servers that end with the test."""
    servers: list[AnnotationServer] = []

    def start(session: Session) -> AnnotationServer:
        server = AnnotationServer(session)
        servers.append(server)
        Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        return server

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()
