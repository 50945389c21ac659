"""Notebooks of the documentation: their cells run in their order, and show what a notebook would show."""

from __future__ import annotations

import ast
import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from virtualrobot import Client

ROOT = Path(__file__).resolve().parents[3]
NOTEBOOKS = ROOT / "docs" / "notebooks"


def cells_of(file: Path) -> list[str]:
    """Return the programs of a notebook's cells; the file holds no results of somebody's own."""
    notebook = json.loads(file.read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["metadata"]["kernelspec"]["language"]) == (4, "python")
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    return ["".join(cell["source"]) for cell in code]


def run(program: str, names: dict[str, Any]) -> object:
    """Run a cell as a notebook does: return what its last line comes to, where that is an expression."""
    tree = ast.parse(program)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # type: ignore[attr-defined]  # pyright: ignore[reportAttributeAccessIssue]


def check_shown(one: object) -> str:
    """Return the kind of what a notebook shows of a value."""
    for kind, begins in (("png", b"\x89PNG"), ("jpeg", b"\xff\xd8"), ("html", "<")):
        show = getattr(one, f"_repr_{kind}_", None)
        if show is not None and (shown := show()) is not None:
            assert shown.startswith(begins)
            return kind
    assert len(repr(one).splitlines()) <= 8, repr(one)
    assert " object at 0x" not in repr(one)
    return "text"


def test_the_cells_of_a_first_cell_run(client: Client, environment: None) -> None:
    names: dict[str, Any] = {}
    kinds = [check_shown(run(cell, names)) for cell in cells_of(NOTEBOOKS / "first-cell.ipynb")]
    assert {"html", "png", "text"} <= set(kinds)


@pytest.mark.long
def test_a_layout_is_found_handed_in_and_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A place of the grid that will do, as the book of exercises has it."""
    shutil.copytree(NOTEBOOKS.parent / "exercises", tmp_path / "exercises")
    (tmp_path / "notebooks").mkdir()
    monkeypatch.chdir(tmp_path / "notebooks")
    names: dict[str, Any] = {}
    kinds = [check_shown(run(cell, names)) for cell in cells_of(NOTEBOOKS / "layout.ipynb")]
    assert kinds.count("html") == 1
    assert (names["free"] == 1.0).sum() == 12
    assert capsys.readouterr().out.splitlines()[-2:] == ["reached: 1 (all): 4 of 4", "free: 1 (all): 6 of 6"]
