"""The documented exchange format, and the script that brings MediaPipe to it."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skeleton_sequences import people_standing, reference_of
from topview.body import JOINT_NAMES, OUTPUT_JOINT_NAMES
from topview.io.writers import write_skeletons_csv
from topview.records import InputError
from topview_lab.evaluate.predictions import Predictions, read_predictions
from topview_lab.evaluate.skeleton_files import read_arrays
from topview_lab.evaluate.vocabulary import find_joints
from topview_lab.metrics import ReferenceSequence

ROOT = Path(__file__).parents[3]
DOCUMENT = (ROOT / "docs" / "bridge.md").read_text()
CAMERA = {"fx": 300.0, "fy": 300.0, "cx": 79.5, "cy": 59.5}


def example(language: str) -> str:
    (text,) = re.findall(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL)
    return text


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "mediapipe_bridge", ROOT / "scripts" / "mediapipe_bridge.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


BRIDGE = script()


@pytest.fixture
def reference() -> ReferenceSequence:
    return reference_of(people_standing(2, 0.0, 0.9))


class TestDocument:
    def test_its_example_is_read(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: ReferenceSequence
    ) -> None:
        monkeypatch.chdir(tmp_path)
        exec(example("python"), {})
        told = read_predictions(tmp_path / "my_recording.npz", reference)
        assert told.present.tolist() == [[True, False], [True, True]]
        assert told.joints_camera[1, 1, 0] == pytest.approx((0.9, -0.7, 2.8))
        # The pelvis is told by the hips.
        assert told.joints_camera[0, 0, told.joint_names.index("pelvis")] == pytest.approx(
            (0.0, 0.05, 2.5)
        )

    def test_its_lines_say_the_same(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: ReferenceSequence
    ) -> None:
        monkeypatch.chdir(tmp_path)
        exec(example("python"), {})
        (tmp_path / "lines.csv").write_text(example("csv"))
        lines = read_predictions(tmp_path / "lines.csv", reference)
        arrays = read_predictions(tmp_path / "my_recording.npz", reference)
        assert lines.joint_names == ("head", "neck")
        told = np.isfinite(lines.joints_camera)
        assert told.all(-1).sum() == 4
        at = [arrays.joint_names.index(name) for name in lines.joint_names]
        np.testing.assert_array_equal(
            lines.joints_camera[told], arrays.joints_camera[:, :, at][told]
        )

    def test_it_tells_what_the_script_does(self) -> None:
        half_cm = {joint: round(100 * m) for joint, m in BRIDGE.HALF_THICKNESS_M.items()}
        assert (
            "{shoulder} cm at a shoulder, {elbow} at an elbow and an ankle, {wrist} at a wrist, "
            "{hip} at a hip, {knee} at a knee, {ear} from the cheek"
        ).format_map(half_cm) in " ".join(DOCUMENT.split())
        assert half_cm["elbow"] == half_cm["ankle"]
        assert f"a square of {100 * BRIDGE.WINDOW_M:.0f} cm" in DOCUMENT


class TestLines:
    def write(self, path: Path, *lines: str) -> Path:
        path.write_text("\n".join(["frame_index,joint,x_m,y_m,z_m,confidence", *lines]))
        return path

    def test_our_own_come_back(self, tmp_path: Path, reference: ReferenceSequence) -> None:
        joints = people_standing(2, -0.5, 0.7)
        joints[1, 1] = np.nan
        np.savez(tmp_path / "a.npz", joint_names=JOINT_NAMES, joints_camera=joints)
        told = read_predictions(tmp_path / "a.npz", reference)
        write_skeletons_csv(told, tmp_path / "skeletons.csv")
        again = read_predictions(tmp_path / "skeletons.csv", reference)
        np.testing.assert_allclose(again.joints_camera, told.joints_camera, atol=1e-5)
        np.testing.assert_array_equal(again.present, told.present)

    def test_lines_may_be_in_any_order_and_missing(self, tmp_path: Path) -> None:
        path = self.write(tmp_path / "a.csv", "7,head,1,2,3,0.5", "3,neck,4,5,6,", "3,head,,,,")
        arrays = read_arrays(path, np.arange(10))
        assert arrays["frame_index"].tolist() == [3, 7]
        assert arrays["joint_names"].tolist() == ["head", "neck"]
        np.testing.assert_array_equal(arrays["joints_camera"][:, 0, 0], [[np.nan] * 3, [1, 2, 3]])
        np.testing.assert_array_equal(arrays["joint_confidence"][1, 0], [0.5, np.nan])

    def test_scattered_lines_take_no_more_memory_than_people_at_once(self, tmp_path: Path) -> None:
        """Everybody in a frame of their own: a column for each would take 50 GB."""
        lines = ["frame_index,person_id,joint,x_m,y_m,z_m"]
        lines += [f"{i},{i},head,0,0,{2 + i / 1e4}" for i in range(25_000)]
        path = tmp_path / "a.csv"
        path.write_text("\n".join(lines))
        arrays = read_arrays(path, np.arange(25_000))
        assert arrays["joints_camera"].shape == (25_000, 1, 1, 3)
        assert len(np.unique(arrays["person_ids"])) == 25_000

    def test_lines_that_no_memory_holds_are_refused(self, tmp_path: Path) -> None:
        lines = ["frame_index,person_id,joint,x_m,y_m,z_m"]
        lines += [f"0,{i},a,0,0,2" for i in range(700)]
        lines += [f"{i},0,b{i},0,0,2" for i in range(1, 700)]
        path = tmp_path / "a.csv"
        path.write_text("\n".join(lines))
        with pytest.raises(InputError, match="up to 700 people in each and 700 joints; their"):
            read_arrays(path, np.arange(700))

    def test_an_archive_goes_before_lines(self, tmp_path: Path) -> None:
        self.write(tmp_path / "a.csv", "0,head,1,2,3,1")
        assert Predictions(tmp_path).file_of("a").suffix == ".csv"
        (tmp_path / "a").mkdir()
        (tmp_path / "a" / "skeletons.npz").touch()
        assert Predictions(tmp_path).file_of("a").suffix == ".npz"

    @pytest.mark.parametrize(
        ("lines", "message"),
        [
            ((), "has no lines"),
            (("x,head,1,2,3,1",), "line 2: frame_index is 'x'"),
            (("-1,head,1,2,3,1",), "line 2: frame_index is '-1'"),
            (("0,head,1,2,wide,1",), "line 2: z_m is 'wide'; it must be a number"),
            (("0,head,1,2,3,1", "0,head,1,2,3,1"), "line 3: head is told again"),
        ],
    )
    def test_refused_in_one_line(
        self, tmp_path: Path, reference: ReferenceSequence, lines: tuple[str, ...], message: str
    ) -> None:
        path = self.write(tmp_path / "a.csv", *lines)
        with pytest.raises(InputError, match=message) as error:
            read_predictions(path, reference)
        assert str(error.value).startswith(str(path))
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize("content", [b"", b"a,b\n1,2\n", b"\xff\xfe\x00", b"frame_index\n\x00"])
    def test_damaged_files(
        self, tmp_path: Path, reference: ReferenceSequence, content: bytes
    ) -> None:
        (tmp_path / "a.csv").write_bytes(content)
        with pytest.raises(InputError, match=r"cannot be read|has no column|is not text"):
            read_predictions(tmp_path / "a.csv", reference)


class TestLifting:
    def test_the_landmarks_are_known_joints(self) -> None:
        assert set(find_joints(BRIDGE.LANDMARKS, "")) == {
            name for name in OUTPUT_JOINT_NAMES if not name.endswith(("torso", "foot"))
        }

    @given(st.floats(0.0, 159.0), st.floats(0.0, 119.0), st.floats(0.6, 6.0))
    def test_they_lie_on_their_rays_below_the_skin(self, u: float, v: float, z_m: float) -> None:
        depth_m = np.full((120, 160), z_m)
        places = BRIDGE.lift(np.tile((u, v), (33, 1)), depth_m, CAMERA)
        columns = places[:, 0] / places[:, 2] * CAMERA["fx"] + CAMERA["cx"]
        np.testing.assert_allclose(columns, u, atol=1e-6)
        skin = places[BRIDGE.LANDMARKS.index("nose")]
        assert skin[2] == pytest.approx(z_m)
        below = np.linalg.norm(places - skin, axis=1)
        np.testing.assert_allclose(below, BRIDGE.PUSH_M, atol=1e-9)

    def test_holes_are_bridged_and_what_is_unknown_is_missing(self) -> None:
        depth_m = np.full((120, 160), 2.0)
        depth_m[60, 80] = 0.0  # one pixel without reading
        depth_m[:, :40] = 0.0  # none at all
        depth_m[:, 120:] = 0.5  # somebody in front
        pixels = np.tile((80.0, 60.0), (33, 1))
        pixels[1:4] = (10.0, 60.0), (140.0, 60.0), (-3.0, 60.0)
        places = BRIDGE.lift(pixels, depth_m, CAMERA)
        assert places[0, 2] == pytest.approx(2.0)
        assert np.isfinite(places).all(-1).nonzero()[0].tolist() == [0, *range(4, 33)]
        assert np.isnan(BRIDGE.lift(pixels, np.zeros((120, 160)), CAMERA)).all()

    def test_a_recording_becomes_predictions(
        self, tmp_path: Path, reference: ReferenceSequence
    ) -> None:
        """With somebody in MediaPipe's place who sees one person in the first frame only."""
        for folder in ("depth", "rgb"):
            (tmp_path / folder).mkdir()
        (tmp_path / "camera.json").write_text(
            '{"fx": 300, "fy": 300, "cx": 79.5, "cy": 59.5, "depth_scale": 0.001}'
        )
        for f in range(2):
            depth = np.full((120, 160), 2500, np.uint16)
            cv2.imwrite(str(tmp_path / "depth" / f"{f:06d}.png"), depth)
        cv2.imwrite(str(tmp_path / "rgb" / "000000.jpg"), np.zeros((120, 160, 3), np.uint8))

        class Landmark:
            x, y, visibility = 0.5, 0.5, 0.8

        class Pose:
            def process(self, _: np.ndarray) -> Pose:
                return self

            @property
            def pose_landmarks(self) -> Pose:
                return self

            landmark = (Landmark(),) * 33

        arrays, _ = BRIDGE.run(tmp_path, Pose())
        np.savez(tmp_path / "a.npz", **arrays)
        told = read_predictions(tmp_path / "a.npz", reference)
        assert told.present.tolist() == [[True], [False]]
        elbow = told.joints_camera[0, 0, told.joint_names.index("left_elbow")]
        assert elbow == pytest.approx((0.0, 0.0, 2.54), abs=1e-6)
