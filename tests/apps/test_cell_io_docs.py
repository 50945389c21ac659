"""The page of cell I/O tells every field and operator of its files."""

from __future__ import annotations

from pathlib import Path

import pytest
from virtualrobot_apps.bridges import mapping
from virtualrobot_apps.bridges.words import TYPES
from virtualrobot_apps.connections import file
from virtualrobot_apps.connections.operators import OPERATORS

PAGE = (Path(__file__).resolve().parent.parent.parent / "docs" / "cell-io.md").read_text("utf-8")


@pytest.mark.parametrize(
    "names",
    [
        *(file.FILE_FIELDS[1:], file.SIGNAL_FIELDS, tuple(file.FIRST_VALUES)),
        *(mapping.FILE_FIELDS[1:], mapping.ENTRY_FIELDS, mapping.MODBUS_FIELDS, tuple(mapping.PLACES.values())),
        *(mapping.TABLES, TYPES, tuple(mapping.PARITIES)),
        *(file.TOOL_FIELDS, file.BELT_FIELDS, tuple(OPERATORS)),
        tuple(
            name for one in OPERATORS.values() for name in (*one.inputs, *one.settings) if name not in ("...", "a", "b")
        ),
    ],
    ids=lambda names: "-".join(names[:2]),
)
def test_each_field_is_told(names: tuple[str, ...]) -> None:
    assert [name for name in names if f"`{name}`" not in PAGE] == []
