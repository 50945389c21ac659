"""Units of the components of RAPID's records.

Source: ABB, *Technical reference manual, RAPID Instructions, Functions and Data types* (3HAC050917), data types.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from virtualrobot_apps.languages.rapid.types import RECORDS
from virtualrobot_apps.languages.rapid.values import value_text

UNITS: dict[str, dict[str, str]] = {
    "pos": dict.fromkeys("xyz", "mm"),
    "robjoint": {f"rax_{number}": "degrees" for number in range(1, 7)},
    "speeddata": {"v_tcp": "mm/s", "v_ori": "degrees/s", "v_leax": "mm/s", "v_reax": "degrees/s"},
    "zonedata": {
        **dict.fromkeys(("pzone_tcp", "pzone_ori", "pzone_eax", "zone_leax"), "mm"),
        **dict.fromkeys(("zone_ori", "zone_reax"), "degrees"),
    },
    "loaddata": {"mass": "kg", **dict.fromkeys(("ix", "iy", "iz"), "kgm^2")},
}
"""Units by type and component; what isn't here has none, or, as an external axis, one that its kind decides."""


def units_of(kind: str, value: Sequence[Any] | None = None) -> list[str]:
    """Return the components of a record that have units, those of its parts too: `v_tcp (mm/s)`, or `v_tcp 100 mm/s`.

    `value` has the components' values.
    """
    found = []
    for number, (inner, name) in enumerate(RECORDS.get(kind, ())):
        held = None if value is None else value[number]
        unit = UNITS.get(kind, {}).get(name, "")
        if unit:
            found.append(f"{name} ({unit})" if held is None else f"{name} {value_text(held)} {unit}")
        found += [f"{name}.{one}" for one in units_of(inner, held)]
    return found
