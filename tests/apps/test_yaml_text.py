"""YAML texts changed in single places: what is read then, and what stays as a person has written it."""

from __future__ import annotations

import pytest
from virtualrobot.errors import MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.cell_io.yaml_text import with_item, with_value

TEXT = """# what it is
schema_version: 1
speed: 0.01  # slowly
tolerance: {rotation: free}
arc:
  signal: on
  end: 2
ways:
- {part: plate}
- part: wall
  edge: concave
last: true
"""


@pytest.mark.parametrize(
    ("path", "before", "after"),
    [
        (("speed",), "speed: 0.01  # slowly", "speed: 5  # slowly"),
        (("tolerance", "rotation"), "{rotation: free}", "{rotation: 5}"),
        (("tolerance", "x"), "{rotation: free}", "{rotation: free, x: 5}"),
        (("arc", "end"), "  end: 2\n", "  end: 5\n"),
        (("arc", "begin"), "  signal: on\n", "  begin: 5\n  signal: on\n"),
        (("speed", "most"), "speed: 0.01 ", "speed: {most: 5} "),
        (("tool", "lean", "x"), "last: true\n", "last: true\ntool: {lean: {x: 5}}\n"),
    ],
)
def test_a_field_has_another_value_and_all_else_stays(path: tuple[str, ...], before: str, after: str) -> None:
    changed = with_value(TEXT, path, "5")
    assert TEXT.count(before) == 1 and changed == TEXT.replace(before, after)
    item = parse(changed, "text.yaml")
    for name in path:
        item = item.mapping()[name]
    assert item.number() == 5.0


@pytest.mark.parametrize(
    ("text", "add", "parts"),
    [
        (TEXT, False, ["new"]),
        (TEXT, True, ["plate", "wall", "new"]),
        ("schema_version: 1\nways: [{part: a},\n  {part: b}]", True, ["a", "b", "new"]),
        ("schema_version: 1\nways: [{part: a}]\n", False, ["new"]),
        ("schema_version: 1\nways: []\n", True, ["new"]),
        ("schema_version: 1\nways:\n  - {part: a}", True, ["a", "new"]),
    ],
)
def test_a_list_has_one_item_more_or_that_alone(text: str, add: bool, parts: list[str]) -> None:
    changed = parse(with_item(text, ["ways"], "{part: new}", add=add), "text.yaml").mapping()
    assert [one.mapping()["part"].text() for one in changed["ways"].items()] == parts
    assert changed.keys() == parse(text, "text.yaml").mapping().keys()


def test_what_is_no_list_is_refused_with_its_line() -> None:
    with pytest.raises(MalformedFileError, match=r"text.yaml:3: speed: a list belongs here"):
        with_item(TEXT, ["speed"], "1", add=True)
