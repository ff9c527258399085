"""What the documents name exists: files, names in them, links, and the fields of settings."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import topview
from documented import COMMANDS, DOCUMENTS, ROOT
from moving_bodies import moving_people
from topview import JOINT_NAMES, PART_NAMES
from topview.cli.app import QUIET, app
from topview.io.writers.registry import FORMATS

# `topview/track/tracker.py:Tracker.update`, a file below src/ or beside it, maybe with a name.
FILE = re.compile(r"`((?:src|scripts|tests|topview|topview_lab)/[\w./]*\.\w+)(?::([\w.]+))?`")
FOLDER = re.compile(r"`((?:src|scripts|tests|docs|topview|topview_lab)/(?:[\w]+/)*)`")
LINK = re.compile(r"\]\((?!https?:)([^)#]+)")
SETTINGS = re.compile(r"^#+ .*`(topview\w*/[\w/]+\.py):(\w+)`.*\n((?:(?!#).*\n)*)", re.MULTILINE)
ROW = re.compile(r"^\| `(\w+)`", re.MULTILINE)

EXAMPLES = [
    example
    for name in ("README.md", "docs/outputs.md", "docs/start.md")
    for example in re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
]


def by_name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def found(place: str) -> Path:
    """Where a place is: below the project's folder, or below src/."""
    beside = ROOT / place
    return beside if beside.exists() else ROOT / "src" / place


@cache
def definitions(path: Path) -> dict[str, list[str]]:
    """The names that a file defines at its top, with those that a class defines; its fields come
    first to last."""
    return {
        name: [inner for part in getattr(node, "body", []) for inner in names_of(part)]
        for node in ast.parse(path.read_text()).body
        for name in names_of(node)
    }


def names_of(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return [node.name]
    if isinstance(node, ast.AnnAssign) and "ClassVar" not in ast.unparse(node.annotation):
        return [ast.unparse(node.target)]
    if isinstance(node, ast.Assign):
        return [ast.unparse(target) for target in node.targets]
    return []


def is_defined(path: Path, name: str) -> bool:
    outer, _, inner = name.partition(".")
    of_class = definitions(path).get(outer)
    return of_class is not None and (not inner or inner in of_class)


@pytest.mark.parametrize("document", DOCUMENTS, ids=by_name)
def test_every_file_and_name_that_a_document_names_exists(document: Path) -> None:
    text = document.read_text()
    missing = [place for place in FOLDER.findall(text) if not found(place).is_dir()]
    for place, name in FILE.findall(text):
        path = found(place)
        if not path.is_file() or (name and not is_defined(path, name)):
            missing.append(f"{place}:{name}" if name else place)
    assert not missing


@pytest.mark.parametrize("document", DOCUMENTS, ids=by_name)
def test_every_link_leads_to_a_file(document: Path) -> None:
    links = LINK.findall(document.read_text())
    assert [link for link in links if not (document.parent / link).exists()] == []


def test_the_documents_name_files_at_all() -> None:
    """The patterns above would let everything pass if they found nothing."""
    text = "".join(document.read_text() for document in DOCUMENTS)
    assert ("topview/track/tracker.py", "Tracker.update") in FILE.findall(text)
    assert "docs/method.md" in LINK.findall((ROOT / "README.md").read_text())
    assert FOLDER.findall(text)
    assert EXAMPLES


@pytest.mark.parametrize("example", EXAMPLES)
def test_the_examples_run(
    example: str, make_recording: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = make_recording()
    recording.rename(recording.with_name("my_recording"))
    monkeypatch.chdir(recording.parent)
    Path("results").mkdir()
    topview.write_skeletons(moving_people(), "results/skeletons.npz")
    exec(compile(example, "example.py", "exec"), {})


@pytest.mark.parametrize(("document", "command"), COMMANDS)
def test_every_command_is_one_that_topview_takes(document: str, command: str) -> None:
    words = [word for word in shlex.split(command) if word != QUIET]
    app.parse_args(words, exit_on_error=False, print_error=False)


def test_every_page_is_in_the_site() -> None:
    site = (ROOT / "mkdocs.yml").read_text()
    pages = [path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")]
    assert [page for page in pages if f"- {page}\n" not in site] == []


def test_the_table_of_names_is_the_package_s() -> None:
    table = (ROOT / "docs" / "outputs.md").read_text().partition("## From Python")[2]
    assert set(re.findall(r"topview\.(\w+)", table)) >= {*topview.__all__}
    assert all(hasattr(topview, name) for name in topview.__all__)
    assert (Path(topview.__file__).parent / "py.typed").exists()


def test_the_table_of_formats_names_all_of_them_and_their_tests() -> None:
    table = (ROOT / "docs" / "outputs.md").read_text()
    assert re.findall(r"^\| `(\w+)`.*\| `?[\w/. ]+`? \|$", table, re.MULTILINE)[: len(FORMATS)] == [
        *FORMATS
    ]
    tests = definitions(ROOT / "tests" / "topview" / "io" / "test_output_formats.py")
    assert set(re.findall(r"`(test_\w+)`", table)) <= {*tests}


def test_the_drawing_names_every_joint_and_part() -> None:
    drawing = (ROOT / "docs" / "pictures" / "body.svg").read_text()
    words = [*re.findall(r">(\w+)</text>", drawing)]
    assert sorted({*words} & {*JOINT_NAMES, *PART_NAMES}) == sorted({*JOINT_NAMES, *PART_NAMES})


SECTIONS = SETTINGS.findall((ROOT / "docs" / "settings.md").read_text())


@pytest.mark.parametrize(("place", "name", "text"), SECTIONS, ids=[name for _, name, _ in SECTIONS])
def test_settings_md_tells_every_field_of_a_class_and_no_other(
    place: str, name: str, text: str
) -> None:
    of_class = ast.parse(found(place).read_text()).body
    (node,) = [node for node in of_class if isinstance(node, ast.ClassDef) and node.name == name]
    fields = [
        field for part in node.body if isinstance(part, ast.AnnAssign) for field in names_of(part)
    ]
    assert ROW.findall(text) == fields


def test_settings_md_tells_of_the_tracker_s_settings() -> None:
    assert "TrackerSettings" in [name for _, name, _ in SECTIONS]
