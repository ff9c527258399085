"""MSR Action3D and ITOP, on tiny files in their published layouts."""

from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.io import open_recording
from topview.records import InputError
from topview.track.settings import TrackerSettings
from topview_lab.datasets import find_itop, find_msr_action3d
from topview_lab.datasets.itop import ITOP_CAMERA, ITOP_JOINTS
from topview_lab.datasets.joints import facing_sides
from topview_lab.datasets.msr_action3d import MSR_JOINTS
from topview_lab.evaluate.run import run_evaluation

W, H, Z_M = 32, 24, 2.6
FOCAL = 285.63 / 10.0


def standing_y_up() -> dict[str, tuple[float, float]]:
    """x, y in metres with y up, of somebody who faces the camera: the left at larger x."""
    heights = {
        "shoulder": (0.18, 0.45), "elbow": (0.24, 0.15), "hand": (0.26, -0.10),
        "hip": (0.09, -0.10), "knee": (0.10, -0.40), "ankle": (0.10, -0.70),
    }  # fmt: skip
    middle = {"head": (0.0, 0.7), "neck": (0.0, 0.5), "torso": (0.0, 0.2), "pelvis": (0.0, -0.1)}
    return middle | {
        f"{side}_{joint}": (sign * x, y)
        for side, sign in (("left", 1), ("right", -1))
        for joint, (x, y) in heights.items()
    }


def rows_of(names: tuple[str, ...], frames: int, sign: float = 1.0) -> NDArray[np.float64]:
    """[F, K, 3] metres, y up; unnamed joints as the pelvis; 5 cm to the right each frame."""
    at = standing_y_up()
    one = np.array([(*at.get(name, (0.0, -0.1)), Z_M) for name in names])
    joints = np.repeat(one[None], frames, 0)
    joints[..., 0] = sign * (joints[..., 0] + 0.05 * np.arange(frames)[:, None])
    return joints


def person_image(joints: NDArray[np.float64], unit_m: float) -> NDArray[np.int32]:
    """[F, H, W] depth units in pixels that have a joint (y up), 0 elsewhere."""
    image = np.zeros((len(joints), H, W), np.int32)
    u = np.rint(joints[..., 0] * FOCAL / Z_M + W / 2).astype(int)
    v = np.rint(-joints[..., 1] * FOCAL / Z_M + H / 2).astype(int)
    image[np.arange(len(joints))[:, None], v, u] = round((Z_M - 0.1) / unit_m)
    return image


def write_depth(path: Path, image: NDArray[np.int32]) -> None:
    F, rows, columns = image.shape
    header = np.array([F, columns, rows], "<i4")
    path.write_bytes(header.tobytes() + image.astype("<i4").tobytes())


class TestMsrAction3d:
    @pytest.fixture
    def root(self, tmp_path: Path) -> Path:
        """The first in millimetres with world coordinates, the second in steps of 4 mm with image
        coordinates."""
        (tmp_path / "Depth").mkdir()
        (tmp_path / "Skeleton").mkdir()
        world = rows_of(MSR_JOINTS, 3)
        confidence = np.ones((3, 20, 1))
        write_depth(tmp_path / "Depth" / "a02_s01_e01_sdepth.bin", person_image(world, 0.001))
        self.write(tmp_path, "a02_s01_e01_skeleton3D", np.concatenate([world, confidence], -1))
        write_depth(tmp_path / "Depth" / "a10_s03_e02_sdepth.bin", person_image(world, 0.004))
        image = np.stack(
            [
                world[..., 0] * FOCAL / Z_M + W / 2,
                -world[..., 1] * FOCAL / Z_M + H / 2,
                world[..., 2] / 0.004,
            ],
            -1,
        )
        self.write(tmp_path, "a10_s03_e02_skeleton", np.concatenate([image, confidence], -1))
        return tmp_path

    @staticmethod
    def write(root: Path, name: str, rows: NDArray[np.float64]) -> None:
        np.savetxt(root / "Skeleton" / f"{name}.txt", rows.reshape(-1, 4), fmt="%.5f")

    def test_sequences_come_in_the_order_of_their_numbers(self, root: Path) -> None:
        assert [s.name for s in find_msr_action3d(root)] == ["a02_s01_e01", "a10_s03_e02"]
        assert [s.name for s in find_msr_action3d(root, "a10*")] == ["a10_s03_e02"]

    def test_frames(self, root: Path) -> None:
        for sequence in find_msr_action3d(root):
            recording = sequence.open()
            frames = list(recording)
            assert len(frames) == recording.frame_count == 3
            assert recording.camera.fx == pytest.approx(FOCAL)
            assert frames[1].depth_m.max() == pytest.approx(Z_M - 0.1)
            assert (frames[1].depth_m == 0.0).mean() > 0.9
        opened = open_recording(root / "Depth" / "a10_s03_e02_sdepth.bin")
        assert next(iter(opened)).depth_m.max() == pytest.approx(Z_M - 0.1)

    def test_both_variants_tell_the_same_joints(self, root: Path) -> None:
        first, second = (sequence.reference() for sequence in find_msr_action3d(root))
        assert set(first.joint_names) == set(JOINT_NAMES)
        assert first.joint_names == second.joint_names
        np.testing.assert_allclose(first.joints_camera, second.joints_camera, atol=1e-3)
        for name, (x, y) in standing_y_up().items():
            k = first.joint_names.index(name)
            assert first.joints_camera[2, 0, k] == pytest.approx((x + 0.1, -y, Z_M), abs=1e-4)
        assert first.actions is not None
        assert first.actions[0, 0] == "a02"
        assert first.bodies == ("subject 01",)

    def test_a_mirrored_x_is_told_by_the_image(self, root: Path) -> None:
        mirrored = rows_of(MSR_JOINTS, 3, sign=-1.0)
        rows = np.concatenate([mirrored, np.ones((3, 20, 1))], -1)
        self.write(root, "a02_s01_e01_skeleton3D", rows)
        reference = find_msr_action3d(root)[0].reference()
        k = reference.joint_names.index("left_elbow")
        assert reference.joints_camera[2, 0, k, 0] == pytest.approx(0.34, abs=1e-4)

    def test_lost_skeletons_have_no_reference(self, root: Path) -> None:
        rows = np.concatenate([rows_of(MSR_JOINTS, 3), np.ones((3, 20, 1))], -1)
        rows[0] = 0.0
        rows[1, 19] = 0.0
        self.write(root, "a02_s01_e01_skeleton3D", rows)
        reference = find_msr_action3d(root)[0].reference()
        assert reference.frame_index.tolist() == [1, 2]
        head = reference.joints_camera[:, 0, reference.joint_names.index("head")]
        assert np.isnan(head[0]).all()
        assert np.isfinite(head[1]).all()

    def test_missing_kinds_are_named_together(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"lacks a01_s01_e01_sdepth\.bin and .*skeleton3D"):
            find_msr_action3d(tmp_path)

    def test_a_missing_or_short_skeleton_loses_one_sequence(self, root: Path) -> None:
        (root / "Skeleton" / "a02_s01_e01_skeleton3D.txt").unlink()
        run = run_evaluation(find_msr_action3d(root), TrackerSettings(), workers=1)
        assert [s.name for s in run.evaluation.sequences] == ["a10_s03_e02"]
        assert "a02_s01_e01_skeleton3D.txt: cannot be read" in run.problems[0]
        rows = np.concatenate([rows_of(MSR_JOINTS, 2), np.ones((2, 20, 1))], -1)
        self.write(root, "a02_s01_e01_skeleton3D", rows)
        with pytest.raises(InputError, match="has 2 frames, its depth 3"):
            find_msr_action3d(root)[0].reference()

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "has 0 lines"),
            ("1 2 3 4\n" * 19, "has 19 lines"),
            ("1 2 x 4\n" * 20, "is damaged"),
            ("1 2 nan 4\n" * 20, "numbers that are not finite"),
            ("1 1e300 3 4\n" * 20, "numbers that are not finite, or beyond 100000"),
        ],
    )
    def test_damaged_skeletons(self, root: Path, text: str, message: str) -> None:
        (root / "Skeleton" / "a02_s01_e01_skeleton3D.txt").write_text(text)
        with pytest.raises(InputError, match=message) as error:
            find_msr_action3d(root)[0].reference()
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize(
        ("size", "message"), [(0, "has 0 bytes"), (11, "has 11 bytes"), (5000, "it must have 9228")]
    )
    def test_truncated_depth(self, root: Path, size: int, message: str) -> None:
        path = root / "Depth" / "a02_s01_e01_sdepth.bin"
        path.write_bytes(path.read_bytes()[:size])
        with pytest.raises(InputError, match=message):
            open_recording(path)

    @pytest.mark.parametrize(("value", "message"), [(0, "no depth reading"), (90000, "median")])
    def test_depth_of_no_known_unit(self, root: Path, value: int, message: str) -> None:
        path = root / "Depth" / "a02_s01_e01_sdepth.bin"
        write_depth(path, np.full((1, H, W), value, np.int32))
        with pytest.raises(InputError, match=message):
            open_recording(path)


class TestSides:
    NAMES = tuple(n for n in JOINT_NAMES if "_" in n)

    def joints(self, sign: float) -> NDArray[np.float64]:
        at = standing_y_up()
        return np.array([[(sign * at[n][0], -at[n][1], 2.0) for n in self.NAMES]] * 3)

    def test_facing_sides_stay_and_mirrored_ones_are_exchanged(self) -> None:
        assert facing_sides(self.NAMES, self.joints(1.0)) == self.NAMES
        exchanged = facing_sides(self.NAMES, self.joints(-1.0))
        for name, other in zip(self.NAMES, exchanged, strict=True):
            assert name.split("_")[1] == other.split("_")[1]
            assert name != other

    def test_a_short_turn_changes_nothing(self) -> None:
        joints = self.joints(1.0)
        joints[1, :, 0] *= -1.0
        joints[2] = np.nan
        joints = np.concatenate([joints, self.joints(1.0)])
        assert facing_sides(self.NAMES, joints) == self.NAMES


class TestItop:
    IDS = ("00_00000", "01_00000", "00_00001", "00_00002", "01_00001", "00_00003")
    VALID = (1, 1, 0, 1, 1, 0)

    @pytest.fixture
    def root(self, tmp_path: Path) -> Path:
        N = len(self.IDS)
        depth = np.zeros((N, 240, 320), np.float16)
        depth[:, 100:140, 150:170] = 2.0 + np.arange(N)[:, None, None]
        joints = rows_of(ITOP_JOINTS, N).astype(np.float32)
        visible = np.ones((N, 15), np.int16)
        visible[3, 6] = 0
        ids = np.array(self.IDS, "S8")
        with h5py.File(tmp_path / "ITOP_side_test_depth_map.h5", "w") as file:
            file["id"], file["data"] = ids, depth
        with h5py.File(tmp_path / "ITOP_side_test_labels.h5", "w") as file:
            file["id"], file["is_valid"] = ids, np.array(self.VALID, np.uint8)
            file["visible_joints"], file["real_world_coordinates"] = visible, joints
        return tmp_path

    def test_each_person_is_a_recording_up_to_the_last_valid_frame(self, root: Path) -> None:
        first, second = find_itop(root)
        assert (first.name, second.name) == ("test_00", "test_01")
        frames = list(first.open())
        assert [frame.index for frame in frames] == [0, 1, 2]
        assert [float(frame.depth_m.max()) for frame in frames] == [2.0, 4.0, 5.0]
        assert [float(frame.depth_m.max()) for frame in second.open()] == [3.0, 6.0]
        assert [s.name for s in find_itop(root, pattern="*_01")] == ["test_01"]

    def test_reference(self, root: Path) -> None:
        reference = find_itop(root)[0].reference()
        assert reference.frame_index.tolist() == [0, 2]
        assert set(reference.joint_names) == set(JOINT_NAMES) - {"pelvis"}
        at = standing_y_up()
        for name, (x, y) in at.items():
            if name in reference.joint_names:
                k = reference.joint_names.index(name)
                assert reference.joints_camera[1, 0, k] == pytest.approx(
                    (x + 0.15, -y, Z_M), abs=1e-5
                )
        assert reference.occluded_by_self is not None
        assert np.argwhere(reference.occluded_by_self).tolist() == [[1, 0, 6]]

    def test_the_camera_is_the_authors(self) -> None:
        x, y, z = 0.3, -0.2, 2.5
        u = ITOP_CAMERA.fx * x / z + ITOP_CAMERA.cx
        v = ITOP_CAMERA.fy * y / z + ITOP_CAMERA.cy
        assert u == pytest.approx(x / (z * 3.50666662e-3) + 160)
        assert v == pytest.approx(y / (z * 3.50666662e-3) + 120)

    def test_missing_files_are_named_together(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"depth_map\.h5 and ITOP_side_test_labels\.h5; they"):
            find_itop(tmp_path)
        with pytest.raises(InputError, match="split is 'val'; it must be train or test"):
            find_itop(tmp_path, "val")

    def test_the_top_view_is_refused(self, tmp_path: Path) -> None:
        (tmp_path / "ITOP_top_test_labels.h5").touch()
        with pytest.raises(InputError, match="the top view is not for this tracker"):
            find_itop(tmp_path)

    @pytest.mark.parametrize("kind", ["depth_map", "labels"])
    def test_damaged_files(self, root: Path, kind: str) -> None:
        path = root / f"ITOP_side_test_{kind}.h5"
        path.write_bytes(path.read_bytes()[:100])
        with pytest.raises(InputError, match="truncated or damaged") as error:
            find_itop(root)[0].open()
        assert path.name in str(error.value)
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize(
        ("kind", "key", "value", "message"),
        [
            ("labels", "id", np.array([b"zero"] * 6), "ids must be like 00_00001"),
            ("labels", "is_valid", None, "has no is_valid"),
            ("labels", "real_world_coordinates", np.zeros((6, 14, 3)), "it must be .'N', 15, 3"),
            ("depth_map", "data", np.zeros((6, 10, 10)), "data has shape"),
        ],
    )
    def test_wrong_content(self, root: Path, kind: str, key: str, value: Any, message: str) -> None:
        with h5py.File(root / f"ITOP_side_test_{kind}.h5", "a") as file:
            del file[key]
            if value is not None:
                file[key] = value
        with pytest.raises(InputError, match=message):
            [(sequence.open(), sequence.reference()) for sequence in find_itop(root)]

    def test_without_h5py_one_line_says_how_to_get_it(
        self, root: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        imported = builtins.__import__

        def refuse(name: str, *others: Any, **more: Any) -> Any:
            if name == "h5py":
                raise ImportError
            return imported(name, *others, **more)

        monkeypatch.setattr(builtins, "__import__", refuse)
        with pytest.raises(InputError, match=r"pip install 'topview\[datasets\]'"):
            find_itop(root)
