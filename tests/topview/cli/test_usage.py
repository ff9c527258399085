from __future__ import annotations

import logging

import pytest

import topview as package


def test_version_and_help(topview):
    from importlib.metadata import version

    assert topview("--version").out.strip() == version(package.__name__)
    shown = topview("--help")
    assert shown.status == 0
    for command in ("track", "evaluate"):
        assert command in shown.out
    assert topview("track", "--help").out.count("--method") == 1


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["trakc"], ["trakc", "track"]),
        (["track"], ["SOURCE"]),
        (["track", "recording"], ["--out"]),
        (["track", "recording", "--out", "o", "--colour"], ["--colour"]),
        (["track", "recording", "another", "--out", "o"], ["another"]),
        (["track", "recording", "--out", "o", "--method", "magic"], ["magic", "topview", "utvr"]),
        (["track", "recording", "--out", "o", "--seed", "x"], ["--seed", "x"]),
        (["track", "recording", "--out", "o", "--seed", "-1"], ["seed", "-1", "0 to"]),
        (["track", "recording", "--out", "o", "--threads", "-2"], ["threads", "-2", "0"]),
    ],
)
def test_wrong_usage_is_one_clear_line(topview, tmp_path, monkeypatch, arguments, named):
    monkeypatch.chdir(tmp_path)
    ended = topview(*arguments)
    assert ended.status == 2
    assert len(ended.complaints) == 1
    for word in named:
        assert word in ended.complaints[0]
    assert not (tmp_path / "o").exists()


def test_quiet_says_nothing_but_the_error(topview, make_recording, tmp_path):
    ended = topview("--quiet", "track", make_recording(), "--out", tmp_path / "out")
    assert ended.out == ""
    (error,) = ended.complaints
    assert "no person was found" in error


def test_a_library_user_hears_of_it_by_logging(make_recording, caplog):
    source = make_recording()
    (source / "depth" / "000001.png").unlink()
    with caplog.at_level("INFO", logger="topview"):
        package.open(source)
    assert [record.levelname for record in caplog.records] == ["INFO", "WARNING"]
    assert "a folder with depth/" in caplog.text
    assert logging.getLogger("topview").handlers  # or Python would print what nobody asked for


def test_a_signal_in_any_command_is_told(topview, monkeypatch):
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("topview.cli.info.contents_of", stopped)
    ended = topview("info", ".")
    assert ended.status == 130
    assert ended.complaints == ["topview: interrupted"]
