"""Notebooks of the documentation: their cells run in their order, and show what a notebook would show."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import pytest
from virtualrobot import Client

ROOT = Path(__file__).resolve().parents[3]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


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


@pytest.mark.parametrize("file", NOTEBOOKS, ids=[file.name for file in NOTEBOOKS])
def test_its_cells_run(file: Path, client: Client, environment: None) -> None:
    names: dict[str, Any] = {}
    kinds = [check_shown(run(cell, names)) for cell in cells_of(file)]
    assert {"html", "png", "text"} <= set(kinds)


def test_there_is_one() -> None:
    assert [file.name for file in NOTEBOOKS] == ["first-cell.ipynb"]
