"""One name of a constant means one value, wherever it is defined."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src"


def constants(text: str) -> Iterator[tuple[str, str]]:
    """Names and values, as they are written, of a module's public constants."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            targets, value = [node.target], node.value
        elif isinstance(node, ast.Assign):
            targets, value = node.targets, node.value
        else:
            continue
        for target in targets:
            for name, own in _named(target, value):
                if name.isupper() and not name.startswith("_"):
                    yield name, own


def _named(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, str]]:
    if isinstance(target, ast.Name):
        yield target.id, ast.unparse(value)
    elif isinstance(target, ast.Tuple):
        written = value.elts if isinstance(value, ast.Tuple) else None
        for k, element in enumerate(target.elts):
            own = ast.unparse(written[k]) if written else f"{ast.unparse(value)}, number {k}"
            if isinstance(element, ast.Name):
                yield element.id, own


def ambiguous_constants(source: Path, room: str) -> dict[str, dict[str, list[str]]]:
    """Constants of a package that have another value in another module, of whatever package: the
    modules by value by name."""
    modules: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for path in sorted(source.rglob("*.py")):
        for name, value in constants(path.read_text()):
            modules[name][value].append(path.relative_to(source).as_posix())
    return {
        name: dict(by_value)
        for name, by_value in modules.items()
        if len(by_value) > 1
        and any(path.startswith(f"{room}/") for paths in by_value.values() for path in paths)
    }


def test_a_constant_of_the_laboratory_has_one_value_under_its_name():
    assert ambiguous_constants(SOURCE, "topview_lab") == {}


def test_the_check_sees_each_way_to_define_a_constant(tmp_path):
    for room, text in {
        "a": "from typing import Final\nX: Final = 1.0\nY, Z = 1, 2\n_OWN = 1\nP, Q = range(2)\n",
        "b": "X = 2.0\nY = 1\nZ: int = 3\n_OWN = 2\nQ, P = range(2)\nlower = 1\n",
        "c": "X = 1.0\nlower = 2\n",
    }.items():
        (tmp_path / room).mkdir()
        (tmp_path / room / "module.py").write_text(text)
    assert set(ambiguous_constants(tmp_path, "a")) == {"X", "Z", "P", "Q"}
    assert set(ambiguous_constants(tmp_path, "c")) == {"X"}
    assert ambiguous_constants(tmp_path, "c")["X"]["1.0"] == ["a/module.py", "c/module.py"]
