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
        written = _elements(value)
        for k, element in enumerate(target.elts):
            own = ast.unparse(written[k]) if written else f"{ast.unparse(value)}, number {k}"
            if isinstance(element, ast.Name):
                yield element.id, own


def _elements(value: ast.expr) -> list[ast.expr] | None:
    """What a tuple, or a range of literal numbers, gives one by one."""
    if isinstance(value, ast.Tuple):
        return value.elts
    if isinstance(value, ast.Call) and ast.unparse(value.func) == "range":
        numbers = [end.value for end in value.args if isinstance(end, ast.Constant)]
        ends = [number for number in numbers if isinstance(number, int)]
        if len(ends) == len(value.args):
            return [ast.Constant(number) for number in range(*ends)]
    return None


def ambiguous_constants(source: Path) -> dict[str, dict[str, list[str]]]:
    """Constants that have another value in another module: the modules by value by name."""
    modules: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for path in sorted(source.rglob("*.py")):
        for name, value in constants(path.read_text()):
            modules[name][value].append(path.relative_to(source).as_posix())
    return {name: dict(by_value) for name, by_value in modules.items() if len(by_value) > 1}


def test_a_constant_has_one_value_under_its_name():
    assert ambiguous_constants(SOURCE) == {}


def test_the_check_sees_each_way_to_define_a_constant(tmp_path):
    for room, lines in {
        "a": ["from typing import Final", "X: Final = 1.0", "Y, Z = 1, 2", "_OWN = 1"],
        "b": ["X = 2.0", "Y = 1", "Z: int = 3", "_OWN = 2", "lower = 1"],
        "c": ["X = 1.0", "lower = 2"],
        "d": ["P, Q, R = range(3)", "M, N = f()", "T, U = range(2, X)"],
        "e": ["Q, P = range(2)", "R = 2", "N, M = f()", "T, U = range(2, X)"],
    }.items():
        (tmp_path / room).mkdir()
        (tmp_path / room / "module.py").write_text("\n".join(lines))
    ambiguous = ambiguous_constants(tmp_path)
    assert set(ambiguous) == {"X", "Z", "P", "Q", "M", "N"}
    assert ambiguous["X"] == {"1.0": ["a/module.py", "c/module.py"], "2.0": ["b/module.py"]}
