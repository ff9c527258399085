"""A simulated recording that the tracker's tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

from topview_lab.sim import scene_by_name, write_scene


@pytest.fixture(scope="session")
def wave_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of 15 frames of somebody who waves."""
    folder = tmp_path_factory.mktemp("wave")
    write_scene(scene_by_name("wave", seed=2, frames=15), folder)
    return folder
