"""What tells people from furniture: the laws of its fit, what is collected, and the command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import numpy as np
import pytest

from skeleton_sequences import write_rendered
from topview.people.features import FEATURE_NAMES, SHAPE
from topview.people.likelihood import Likelihood, shipped_likelihood
from topview.people.track import Track
from topview.records import InputError
from topview_lab.cli import train_people as command
from topview_lab.datasets import SimulatedScene
from topview_lab.training.people import (
    Collected,
    CollectJob,
    KnownPeople,
    TrackRows,
    TrueExistence,
)
from topview_lab.training.people_fit import (
    called_people,
    described,
    fit_likelihood,
    fit_motion,
)

AGAINST, FOR, NOTHING = (FEATURE_NAMES.index(name) for name in ("flat", "too low", "rough outline"))


def made_up(seed: int = 0, people: int = 150, furniture: int = 300) -> TrackRows:
    """Furniture is flat, people are low (which may not speak for them), outlines say nothing."""
    rng = np.random.default_rng(seed)
    is_person = np.arange(people + furniture) < people
    features = np.zeros((len(is_person), len(FEATURE_NAMES)))
    features[:, AGAINST] = rng.uniform(0.0, 2.0, len(is_person)) + 1.5 * ~is_person
    features[:, FOR] = 2.0 * is_person
    features[:, NOTHING] = rng.uniform(0.0, 1.0, len(is_person))
    network = rng.normal(0.0, 1.0, len(is_person)) + np.where(is_person, 2.0, -2.0)
    is_asked = np.arange(len(is_person)) % 3 > 0
    return TrackRows(features, np.where(is_asked, network, 0.0), is_asked, is_person)


def part_of(rows: TrackRows, which: Any) -> TrackRows:
    return TrackRows(
        rows.features[which], rows.network[which], rows.is_asked[which], rows.is_person[which]
    )


def test_what_only_furniture_has_speaks_against_people() -> None:
    likelihood = fit_likelihood(made_up(), "made up")
    weights = np.array([likelihood.weights[name] for name in FEATURE_NAMES])
    assert (weights >= 0.0).all()
    assert weights[AGAINST] > 1.0
    assert weights[FOR] == 0.0
    assert weights[NOTHING] < 0.2 * weights[AGAINST]
    assert likelihood.by_shape > 0.0
    assert likelihood.by_network > 0.0
    people, furniture = called_people(likelihood, made_up(seed=1))
    assert (people.frames, furniture.frames) == (150, 300)
    assert furniture.by_shape < 0.05 < people.by_shape < people.with_network
    assert furniture.with_network < 0.05


@pytest.mark.parametrize("kind", ["people", "furniture", "nobody"])
def test_what_motion_tells_is_learnt_alone(kind: str) -> None:
    """Of recordings in which only people move, only furniture, or nobody."""
    rows, before = made_up(), fit_likelihood(made_up(), "made up")
    moves = {"people": rows.is_person, "furniture": ~rows.is_person, "nobody": False}[kind]
    still = 1.0 - 0.9 * (moves & (np.arange(len(rows)) % 4 > 0))
    features = np.column_stack([rows.features[:, : len(SHAPE)], still, still * np.log(3.0)])
    after = fit_motion(replace(rows, features=features), before, "moved")
    changed = {name for name in FEATURE_NAMES if after.weights[name] != before.weights[name]}
    assert changed <= set(FEATURE_NAMES[len(SHAPE) :])
    assert min(after.weights.values()) >= 0.0
    for shape in rows.features[:, : len(SHAPE)]:
        just_come = before.log_odds_of_shape(shape)
        assert after.log_odds_of_shape(shape) == pytest.approx(just_come, abs=2e-3)
    gains = np.array([after.log_odds_of(own) for own in features])
    gains -= [before.log_odds_of_shape(own[: len(SHAPE)]) for own in features]
    has_moved = still < 1.0
    if kind == "people":
        assert gains[has_moved].min() > 1.0
    else:
        assert gains.max() < 0.05
    network = ("joint_bias", "by_shape", "by_network", "by_stillness")
    assert all(getattr(after, name) == getattr(before, name) for name in network)
    assert after.source == "made up; what motion tells: moved"
    again = fit_motion(replace(rows, features=features), after, "moved again")
    assert again.source == "made up; what motion tells: moved again"
    assert again.bias == pytest.approx(after.bias, abs=2e-3)


def test_the_more_furniture_there_is_the_less_likely_is_a_person() -> None:
    rows = made_up()
    twice = TrackRows.joined([rows, part_of(rows, ~rows.is_person)])
    assert fit_likelihood(twice, "").bias < fit_likelihood(rows, "").bias


def test_what_is_written_is_read_again() -> None:
    likelihood = fit_likelihood(made_up(), "made up")
    encoded = msgspec.json.encode(likelihood)
    assert b"-0.0" not in encoded
    assert msgspec.json.decode(encoded, type=Likelihood) == likelihood


def test_what_ships_weighs_each_feature_against_people() -> None:
    weights = shipped_likelihood().weights
    assert tuple(weights) == FEATURE_NAMES
    assert min(weights.values()) >= 0.0


def test_one_kind_alone_teaches_nothing() -> None:
    rows = made_up()
    with pytest.raises(InputError, match="no piece of furniture was followed"):
        fit_likelihood(part_of(rows, rows.is_person), "")
    with pytest.raises(InputError, match="no person's head was followed"):
        fit_likelihood(part_of(rows, ~rows.is_person), "")
    with pytest.raises(InputError, match="no piece of furniture was shown to the joint network"):
        fit_likelihood(replace(rows, is_asked=rows.is_person), "")


def test_recordings_in_words() -> None:
    names = [
        "cross_060_tof",
        "cross_000",
        "pass_by_7",
        "lobby",
        *(f"sit_{k:03d}" for k in range(9)),
    ]
    assert described(names) == (
        "13 recordings: cross 0, 60; pass_by 7; lobby; sit 0 to 8 (9 of them)"
    )


def track_at(x_m: float, id: int = 0) -> Track:
    """What a label depends on."""
    return cast(Track, SimpleNamespace(id=id, place_camera=np.array([x_m, 0.0, 2.0])))


def test_whose_track_it_is() -> None:
    """One true head, at 0: near it a person, far from it furniture, a double beside the confirmed
    one furniture, too."""
    existence = TrueExistence()
    assert existence.label_of(track_at(0.0), []) is False
    existence.heads_camera = np.array([[0.0, 0.0, 2.0]])
    labels = [existence.label_of(track_at(x_m), []) for x_m in (0.1, 0.24, 0.3, 0.44, 0.5, -0.5)]
    assert labels == [True, True, None, None, False, False]
    person, double = track_at(0.05, id=1), track_at(0.2)
    assert existence.label_of(double, [person, double]) is False
    assert existence.label_of(person, [person, double]) is True
    assert existence.label_of(double, [track_at(0.3, id=1), double]) is True


def test_whose_cluster_it_is() -> None:
    """Who has the head has the cluster; what is near a person may be a part of somebody."""
    existence = TrueExistence()
    points = np.array([[0.1, 0.0, 2.0], [0.5, 0.0, 2.0]])
    assert existence.label_of_cluster(points) is False
    existence.heads_camera = np.array([[0.0, 0.0, 2.0], [9.0, 0.0, 2.0]])
    away = np.array([1.0, 0.0, 0.0])
    labels = [existence.label_of_cluster(points + x_m * away) for x_m in (0.0, 0.1, 0.8, 1.0)]
    assert labels == [True, None, None, False]


@pytest.mark.slow
def test_what_is_collected_of_a_simulated_person() -> None:
    collected = CollectJob(SimulatedScene("stand", frames=3))()
    assert collected.problems == ()
    assert collected.rows is not None
    assert collected.rows.is_person.any()
    assert collected.rows.is_asked.any()
    assert (collected.rows.features >= 0.0).all()


class MadeUpJob:
    """Collects made-up rows; nothing of a recording that is called broken."""

    def __init__(self, recording: KnownPeople) -> None:
        self.name = recording.name

    def __call__(self) -> Collected:
        if self.name.startswith("broken"):
            return Collected(self.name, None, (f"{self.name}: is broken",))
        return Collected(self.name, made_up(int(self.name[-1]), people=40, furniture=60))


def write_people(folder: Path) -> Path:
    shares = {"person_occ_inter": np.zeros((1, 1)), "person_outside": np.zeros((1, 1))}
    return write_rendered(folder, [2.0], **shares)


def test_the_command_fits_measures_and_writes(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "CollectJob", lambda recording, _: MadeUpJob(recording))
    for name in ("broken_0", "walk_1", "walk_2", "walk_3", "walk_4"):
        write_people(tmp_path / "all" / name)
    out = tmp_path / "a.json"
    done = topview("train-people", tmp_path / "all", "--out", out, "--workers", 1)
    assert (done.status, done.complaints) == (2, ["topview: broken_0: is broken"])
    assert all(len(line) <= 80 for line in done.out.splitlines()[:-1])
    assert {"3 fitted", "1 held back"} <= {line[:11].strip() for line in done.out.splitlines()}
    likelihood = msgspec.json.decode(out.read_bytes(), type=Likelihood)
    assert likelihood.source == "3 recordings: walk 1, 2, 4; topview train-people all"
    names = {1: 0, 2: 0, 4: 0}
    rows = TrackRows.joined([made_up(k, people=40, furniture=60) for k in names])
    assert likelihood == fit_likelihood(rows, likelihood.source)
    again = ("--motion-only", "--out", out, "--force", "--workers", 1)
    assert topview("train-people", tmp_path / "all", *again).status == 2  # one is broken
    likelihood = msgspec.json.decode(out.read_bytes(), type=Likelihood)
    said = "3 recordings: walk 1, 2, 4; topview train-people all --motion-only"
    assert likelihood == fit_motion(rows, shipped_likelihood(), said)
    done = topview("train-people", tmp_path / "all", "--every", 2, "--workers", 1)
    assert "2 given" in done.out
    assert shipped_likelihood().source in done.out.replace("\n", " ")


def test_bad_input_is_one_line(tmp_path, topview, monkeypatch) -> None:
    monkeypatch.setattr(command, "CollectJob", lambda recording, _: MadeUpJob(recording))
    good, empty, out = write_people(tmp_path / "walk_1"), tmp_path / "empty", tmp_path / "a.json"
    broken = write_people(tmp_path / "broken_1")
    empty.mkdir()
    out.write_text("kept")
    for arguments, said in (
        ((), "there is nothing to learn from"),
        ((good, "--every", 0), "--every is 0"),
        ((good, "--workers=-1"), "workers is -1"),
        ((good, "--out", out), "--force replaces it"),
        ((tmp_path / "none",), "is not a folder"),
        ((empty,), "no groundtruth.npz"),
        ((good, "--measure", empty), "no groundtruth.npz"),
        ((good, "--measure", good), "--measure names walk_1, which is to be learnt from"),
        (("--simulated", "somewhere"), "somewhere"),
        ((good, "--motion-only"), "--motion-only needs --out"),
        ((broken,), "none of the 1 recordings could be used"),
    ):
        refused = topview("train-people", *arguments)
        assert refused.status == 2
        assert said in refused.complaints[-1]
    assert out.read_text() == "kept"


def test_nobody_is_found_in_images_of_a_wall(tmp_path, topview) -> None:
    refused = topview("train-people", write_people(tmp_path / "a"), "--workers", 1)
    assert refused.status == 2
    assert "no person's head was followed" in refused.complaints[-1]
