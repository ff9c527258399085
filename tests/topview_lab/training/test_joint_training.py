"""The network of joints learns, goes on where it was, and writes what the tracker loads."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labelled_people import discs, write_recording
from topview.cli.main import main
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import silent_onnxruntime
from topview.records import InputError
from topview_lab.cli import train_joints as command
from topview_lab.training.joints.recordings import gathered
from topview_lab.training.joints.windows import AS_THEY_ARE, labelled_window

torch = pytest.importorskip("torch", reason="learning joints needs the extra `train`")

from topview_lab.training.joints import learning  # noqa: E402
from topview_lab.training.joints.export import exported  # noqa: E402
from topview_lab.training.joints.learning import LearningSettings, learn, proposed  # noqa: E402
from topview_lab.training.joints.net import JointNet, NetSettings  # noqa: E402

torch.set_num_threads(1)
SAMPLES = gathered([discs(1, 1)])
SMALL = NetSettings((8, 8, 8, 8), features=8)
HOW = LearningSettings(windows=20, batch=4, rate=1e-2, average=0.5)


def nothing(_: learning.Step) -> None:
    """No report."""


def windows(count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.array([labelled_window(SAMPLES, 0, rng, AS_THEY_ARE).image for _ in range(count)])


def test_what_is_learnt_is_known_afterwards(tmp_path: Path) -> None:
    """One window, seen often enough, is known within 4 cm, which is far more than chance."""
    how = replace(HOW, windows=320)
    net = learn(SAMPLES, SMALL, how, AS_THEY_ARE, tmp_path / "a", nothing)
    truth = labelled_window(SAMPLES, 0, np.random.default_rng(0), AS_THEY_ARE).places
    before, after = (
        np.abs(proposed(tried, windows(1))[0][0, 0] - truth).mean() * 1.2
        for tried in (JointNet(SMALL).eval(), net)
    )
    assert after < 0.04 < before / 4


def test_a_stopped_training_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    whole = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "whole", nothing)

    class StoppedError(Exception):
        pass

    def stop(step: learning.Step) -> None:
        if step.step == 3:
            raise StoppedError

    with pytest.raises(StoppedError):
        learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "half", stop, report_steps=1, save_s=0.0)
    half = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "half", nothing)
    for name, weights in whole.state_dict().items():
        torch.testing.assert_close(half.state_dict()[name], weights, rtol=0.0, atol=0.0)


def test_a_checkpoint_of_another_training_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a"
    learn(SAMPLES, SMALL, replace(HOW, windows=4), AS_THEY_ARE, path, nothing)
    with pytest.raises(InputError, match="was begun with another seed"):
        learn(SAMPLES, SMALL, replace(HOW, windows=4, seed=1), AS_THEY_ARE, path, nothing)
    path.write_bytes(b"nothing of the kind")
    with pytest.raises(InputError, match="no checkpoint that can be read"):
        learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, path, nothing)
    torch.save({"format": "another"}, path)
    with pytest.raises(InputError, match="no checkpoint of `topview train-joints`"):
        learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, path, nothing)


def test_exported_weights_say_the_same() -> None:
    """Through half precision, whatever the number of people."""
    torch.manual_seed(0)
    net = JointNet(NetSettings()).eval()
    session = silent_onnxruntime().InferenceSession(exported(net))
    assert session.get_modelmeta().custom_metadata_map["joint_names"] == ",".join(PROPOSED_JOINTS)
    for count in (1, 3):
        images = np.random.default_rng(count).normal(size=(count, 3, 128, 128)).astype(np.float32)
        answers = session.run(None, {"windows": images})
        for answer, expected in zip(answers, proposed(net, images), strict=True):
            np.testing.assert_allclose(answer, expected, atol=0.01)


def test_the_command_learns_measures_and_writes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_recording(tmp_path / "a", discs(2, 1))
    out = tmp_path / "weights" / "joints.onnx"
    options = ["--out", str(out), "--windows", "64", "--measure", str(folder)]
    with pytest.raises(SystemExit) as end:
        main(["train-joints", str(folder), *options])
    assert end.value.code == 0
    said = capsys.readouterr().out
    assert "trained on 64 windows of 1 recordings" in said
    assert "left_wrist" in said
    names = sorted(path.name.removeprefix("joints.onnx") for path in out.parent.iterdir())
    assert names == ["", ".cache", ".checkpoint", ".losses.json", ".losses.png"]


def test_bad_numbers_and_missing_torch_are_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "a.onnx"
    with pytest.raises(InputError, match="--windows is 0"):
        command.train_joints([tmp_path], out=out, windows=0)
    with pytest.raises(InputError, match="--threads is -1"):
        command.train_joints([tmp_path], out=out, threads=-1)
    with pytest.raises(InputError, match="--seed is -1"):
        command.train_joints([tmp_path], out=out, seed=-1)
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    with pytest.raises(InputError, match="needs torch and onnx"):
        command.train_joints([tmp_path], out=out)
