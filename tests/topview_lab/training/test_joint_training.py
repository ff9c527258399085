"""The network of joints learns, goes on where it was, and writes what the tracker loads."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labelled_people import discs, write_recording
from topview.cli.main import main
from topview.detect.joints import PROPOSED_JOINTS
from topview.detect.joints.network import OUTPUTS, opened, silent_onnxruntime
from topview.detect.joints.proposals import FACING_MODE
from topview.detect.joints.windows import OWN
from topview.records import InputError
from topview_lab.cli import train_joints as command
from topview_lab.training.joints.measuring import INTERVALS, facing_sine, measure
from topview_lab.training.joints.recordings import gathered
from topview_lab.training.joints.windows import AS_THEY_ARE, Variation, labelled_window

torch = pytest.importorskip("torch", reason="learning joints needs the extra `train`")

from topview_lab.training.joints import learning  # noqa: E402
from topview_lab.training.joints.export import exported  # noqa: E402
from topview_lab.training.joints.imported import imported  # noqa: E402
from topview_lab.training.joints.learning import LearningSettings, learn  # noqa: E402
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


def test_who_faces_the_camera_teaches_its_mode() -> None:
    """Left on the image's right: facing; mirrored: turned away; sideways or unknown: both."""
    places = torch.zeros(4, len(PROPOSED_JOINTS), 3)
    left, right = PROPOSED_JOINTS.index("left_hip"), PROPOSED_JOINTS.index("right_hip")
    places[0, left, 0], places[0, right, 0] = 0.1, -0.1
    places[1] = places[0] * torch.tensor([-1.0, 1.0, 1.0])
    places[2, left, 2], places[2, right, 2] = 0.1, -0.1
    places[3] = places[0]
    is_known = torch.ones(4, len(PROPOSED_JOINTS), dtype=torch.bool)
    is_known[3, right] = is_known[3, PROPOSED_JOINTS.index("right_shoulder")] = False
    shares = learning.mode_shares(places, is_known, sharpness=6.0)
    torch.testing.assert_close(shares.sum(dim=1), torch.ones(4))
    assert shares[0, FACING_MODE] > 0.99
    torch.testing.assert_close(shares[1], shares[0].flip(0))
    torch.testing.assert_close(shares[2:], torch.full((2, 2), 0.5))


def test_owners_are_told_no_finer_than_the_heat_maps() -> None:
    """Which pixels of a cell are the person's makes no difference; how many of them does."""
    net = JointNet(SMALL).eval()
    image = windows(1)
    moved, fewer = image.copy(), image.copy()
    cell = np.s_[:, OWN, 64:68, 64:68]
    image[cell], moved[cell], fewer[cell] = 0.0, 0.0, 0.0
    image[:, OWN, 64], moved[:, OWN, 67] = 1.0, 1.0
    moved[:, OWN, 64], image[:, OWN, 67] = 0.0, 0.0
    said = proposed(net, image)[0]
    np.testing.assert_allclose(proposed(net, moved)[0], said, atol=1e-6)
    assert not np.allclose(proposed(net, fewer)[0], said, atol=1e-6)


def test_a_stopped_training_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    """Also with another number of processes that vary the windows."""
    whole = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "whole", nothing)

    class StoppedError(Exception):
        pass

    def stop(step: learning.Step) -> None:
        if step.step == 3:
            raise StoppedError

    with pytest.raises(StoppedError):
        learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "half", stop, report_steps=1, save_s=0.0)
    half = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "half", nothing, workers=2)
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


@torch.no_grad()
def proposed(net: JointNet, images: np.ndarray) -> tuple[np.ndarray, ...]:
    """What a network says of [B, 3, 128, 128] windows."""
    return tuple(out.numpy() for out in net(torch.from_numpy(images)))


def noise(count: int) -> np.ndarray:
    """[count, 3, 128, 128]."""
    return np.random.default_rng(count).normal(size=(count, 3, 128, 128)).astype(np.float32)


def test_exported_weights_say_nearly_the_same() -> None:
    """Through whole numbers, whatever the number of people. Some processors add them in 16 bits,
    which overflow, unless told not to; that is not the weights' fault."""
    torch.manual_seed(0)
    net = JointNet(NetSettings()).eval()
    shown = torch.from_numpy(noise(8))
    onnxruntime = silent_onnxruntime()
    exact = onnxruntime.SessionOptions()
    exact.add_session_config_entry("session.x64quantprecision", "1")
    session = onnxruntime.InferenceSession(exported(net, shown), exact)
    assert session.get_modelmeta().custom_metadata_map["joint_names"] == ",".join(PROPOSED_JOINTS)
    for count in (1, 3):
        images = noise(count)
        answers = session.run(None, {"windows": images})
        for answer, expected in zip(answers, proposed(net, images), strict=True):
            np.testing.assert_allclose(answer, expected, atol=0.02)


def test_the_command_learns_measures_and_writes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_recording(tmp_path / "a", discs(2, 1))
    out = tmp_path / "weights" / "joints.onnx"
    options = ["--out", str(out), "--windows", "16", "--batch", "8"]
    options += ["--postures", "1", "--measure", str(folder)]
    with pytest.raises(SystemExit) as end:
        main(["train-joints", str(folder), *options])
    assert end.value.code == 0
    said = capsys.readouterr().out
    assert "trained on 16 windows of 2 recordings" in said
    assert "left_wrist" in said
    names = sorted(path.name.removeprefix("joints.onnx") for path in out.parent.iterdir())
    beside = [".cache", ".checkpoint", ".losses.json", ".losses.png", ".reliability.png"]
    assert names == ["", *beside]
    assert "of the 90 % intervals hold" in said


@pytest.mark.slow
def test_small_steps_change_little(tmp_path: Path) -> None:
    """Weights that are gone on from by tiny steps say what they said; by large ones they do not."""
    folder = write_recording(tmp_path / "a", discs(2, 1))
    begun = tmp_path / "begun.onnx"
    command.train_joints([folder], out=begun, windows=16, batch=8)
    image = learning.first_windows(SAMPLES, AS_THEY_ARE, 0, 1).numpy()

    def places_by(rate: float) -> np.ndarray:
        out = tmp_path / f"{rate}.onnx"
        command.train_joints([folder], out=out, start_from=[begun], windows=16, batch=8, rate=rate)
        return opened(out.read_bytes()).answers(image)["places"]

    before = opened(begun.read_bytes()).answers(image)["places"]
    tiny, large = (np.abs(places_by(rate) - before).max() for rate in (1e-7, 1e-2))
    assert tiny < 0.02 < large


def test_intervals_are_counted_in_view_and_hidden_apart() -> None:
    """A network that is right but for hidden joints, which are a scale and a half off in depth."""
    recording = discs(2, 1)
    hidden = np.zeros(recording.hidden.shape, np.float32)
    hidden[..., ::2] = 0.5
    samples = gathered([replace(recording, hidden=hidden)])
    truths = iter(
        labelled_window(samples, number, np.random.default_rng(0), AS_THEY_ARE)
        for number in range(len(samples))
    )

    def network(_: np.ndarray) -> dict[str, np.ndarray]:
        places = next(truths).places[None, None].copy()
        scales = np.full(places.shape, 0.01, np.float32)
        places[..., ::2, 2] += 0.015
        answers = places, np.log(scales), np.zeros((1, 1)), np.ones(1)
        return dict(zip(OUTPUTS, answers, strict=True))

    scores = measure(network, samples, 1, lambda: None)
    assert (scores.held_in_view == 1.0).all()
    assert (scores.held_hidden[:, :2] == 1.0).all()
    held = scores.held_hidden[:, 2]
    # A logistic law of a Laplace law's median holds this share within 1.5 of that law's scales.
    share = np.tanh(0.75 * np.log(3.0) / np.log(2.0))
    np.testing.assert_array_equal(held, np.array(INTERVALS) > share)


def test_bad_numbers_and_missing_torch_are_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "a.onnx"
    with pytest.raises(InputError, match=r"--windows is 0; .* or 0 with --start-from"):
        command.train_joints([tmp_path], out=out, windows=0)
    with pytest.raises(InputError, match="--postures is -1"):
        command.train_joints([tmp_path], out=out, postures=-1)
    with pytest.raises(InputError, match="--threads is -1"):
        command.train_joints([tmp_path], out=out, threads=-1)
    with pytest.raises(InputError, match="--seed is -1"):
        command.train_joints([tmp_path], out=out, seed=-1)
    with pytest.raises(InputError, match="--batch is 0; it must be 1 to"):
        command.train_joints([tmp_path], out=out, batch=0)
    with pytest.raises(InputError, match=r"--rate is 0\.0; it must be more than 0"):
        command.train_joints([tmp_path], out=out, rate=0.0)
    with pytest.raises(InputError, match=r"--keep is 0\.5; it must be 0, or with --start-from"):
        command.train_joints([tmp_path], out=out, keep=0.5)
    with pytest.raises(InputError, match="--workers is 0; it must be 1 to"):
        command.train_joints([tmp_path], out=out, workers=0)
    if not torch.cuda.is_available():
        with pytest.raises(InputError, match="--device is cuda, but torch finds no GPU"):
            command.train_joints([tmp_path], out=out, device="cuda")
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    with pytest.raises(InputError, match="needs torch and onnx"):
        command.train_joints([tmp_path], out=out)


def test_the_sine_says_who_faces_the_camera() -> None:
    """Left on the image's right is 1; in the mirror -1; somebody sideways, or in parts, 0."""
    window = labelled_window(SAMPLES, 0, np.random.default_rng(0), AS_THEY_ARE)
    places, across = np.zeros_like(window.places), np.zeros_like(window.places)
    across[[name.startswith("left") for name in PROPOSED_JOINTS], 0] = 0.1
    for turned, sine in ((across, 1.0), (-across, -1.0), (across[:, ::-1], 0.0)):
        assert facing_sine(replace(window, places=places + turned)) == pytest.approx(sine)
    nobody = np.zeros_like(window.is_known)
    assert facing_sine(replace(window, places=across, is_known=nobody)) == 0.0


def test_weights_are_gone_on_from_as_they_are(tmp_path: Path) -> None:
    """What was exported and imported says the same, also by what its windows bring."""
    how = replace(HOW, windows=80)
    net = learn(SAMPLES, SMALL, how, AS_THEY_ARE, tmp_path / "a", nothing)
    images = learning.first_windows(SAMPLES, Variation(), 0, 8)
    (tmp_path / "weights.onnx").write_bytes(exported(net, images))
    begun = imported(tmp_path / "weights.onnx", images)
    assert begun.settings == SMALL
    before, after = proposed(net, images.numpy()), proposed(begun, images.numpy())
    learnt_on = [out.detach().numpy() for out in begun.train()(images)]
    for was, now, training in zip(before, after, learnt_on, strict=True):
        np.testing.assert_allclose(now, was, atol=0.02)  # whole numbers of 8 bits
        np.testing.assert_allclose(training, now, atol=1e-3)


def test_what_is_kept_lies_between_before_and_after(tmp_path: Path) -> None:
    """All kept says what was said before, nothing kept what was learnt, but of who is a person."""
    before = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "a", nothing)
    after = learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "b", nothing, begun=before)
    images = windows(2)
    half = learning.mean_of((before, after), (0.5, 0.5))
    assert not torch.equal(after.person.out.weight, before.person.out.weight)
    assert torch.equal(half.person.out.weight, before.person.out.weight)
    after.person.load_state_dict(before.person.state_dict())
    for kept, expected in ((1.0, before), (0.0, after)):
        for now, own in zip(
            proposed(learning.mean_of((before, after), (kept, 1.0 - kept)), images),
            proposed(expected, images),
            strict=True,
        ):
            np.testing.assert_allclose(now, own, atol=1e-5)
    mean = 0.5 * (before.weight + after.weight)
    np.testing.assert_allclose(half.weight.detach(), mean.detach(), atol=1e-6)


def test_several_weights_begin_as_their_mean(tmp_path: Path) -> None:
    folder, images = write_recording(tmp_path / "one", discs(2, 1)), windows(4)
    wider = replace(SMALL, features=SMALL.features + 1)
    nets = [learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "a", nothing)]
    nets.append(learn(SAMPLES, SMALL, HOW, AS_THEY_ARE, tmp_path / "b", nothing, begun=nets[0]))
    nets.append(learn(SAMPLES, wider, HOW, AS_THEY_ARE, tmp_path / "c", nothing))
    paths = [tmp_path / f"{number}.onnx" for number in range(len(nets))]
    for path, net in zip(paths, nets, strict=True):
        path.write_bytes(exported(net, torch.from_numpy(images)))
    out = tmp_path / "mean.onnx"
    command.train_joints([folder], out=out, start_from=paths[:2], windows=0)
    of_each, of_mean = (
        [opened(own.read_bytes()).answers(images)["places"] for own in paths[:2]],
        opened(out.read_bytes()).answers(images)["places"],
    )
    apart = np.abs(of_each[0] - of_each[1]).max()
    assert apart > 0.05
    for own in of_each:
        assert np.abs(of_mean - own).max() < apart
    with pytest.raises(InputError, match=r"2\.onnx is a network of another size than .*1\.onnx"):
        command.train_joints([folder], out=tmp_path / "no.onnx", start_from=paths[1:], windows=0)


def test_weights_of_something_else_are_refused(tmp_path: Path) -> None:
    images = learning.first_windows(SAMPLES, AS_THEY_ARE, 0, 2)
    path = tmp_path / "weights.onnx"
    path.write_bytes(b"no network")
    with pytest.raises(InputError, match=r"weights\.onnx is no \.onnx that can be read"):
        imported(path, images)
    with pytest.raises(InputError, match=r"none\.onnx"):
        imported(tmp_path / "none.onnx", images)
