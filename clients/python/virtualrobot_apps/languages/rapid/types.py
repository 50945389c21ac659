"""Types of RAPID: atomic ones, records and their components, aliases, and which values go where.

Source of the records: ABB, *RAPID Reference Manual*, Data Types and System Data (3HAC 7783-1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


class Type(NamedTuple):
    """A type by its name in small letters, and the number of dimensions of an array; `any` fits everything."""

    name: str
    dimensions: int = 0

    def __str__(self) -> str:
        """Return it as a parameter has it."""
        return self.name + (f"{{{','.join('*' * self.dimensions)}}}" if self.dimensions else "")


NUM, BOOL, STRING, ANY, SWITCH = Type("num"), Type("bool"), Type("string"), Type("any"), Type("switch")

ATOMIC = (
    *("num", "dnum", "bool", "string", "clock", "socketdev", "iodev", "dir", "rawbytes", "triggdata", "syncident"),
    *("shapedata", "mecunit", "egmident"),
)
"""Types whose values are one thing."""

SIGNALS = {
    "signaldi": bool,
    "signaldo": bool,
    "signalgi": int,
    "signalgo": int,
    "signalai": float,
    "signalao": float,
}
"""Types of signals; of the kernel's signals they take any whose value can be converted."""

RECORDS: dict[str, list[tuple[str, str]]] = {
    name: [(part.partition(":")[2], part.partition(":")[0]) for part in parts.split()]
    for name, parts in {
        "pos": "x:num y:num z:num",
        "orient": "q1:num q2:num q3:num q4:num",
        "pose": "trans:pos rot:orient",
        "confdata": "cf1:num cf4:num cf6:num cfx:num",
        "extjoint": "eax_a:num eax_b:num eax_c:num eax_d:num eax_e:num eax_f:num",
        "robjoint": "rax_1:num rax_2:num rax_3:num rax_4:num rax_5:num rax_6:num",
        "jointtarget": "robax:robjoint extax:extjoint",
        "robtarget": "trans:pos rot:orient robconf:confdata extax:extjoint",
        "speeddata": "v_tcp:num v_ori:num v_leax:num v_reax:num",
        "zonedata": "finep:bool pzone_tcp:num pzone_ori:num pzone_eax:num zone_ori:num zone_leax:num zone_reax:num",
        "loaddata": "mass:num cog:pos aom:orient ix:num iy:num iz:num",
        "tooldata": "robhold:bool tframe:pose tload:loaddata",
        "wobjdata": "robhold:bool ufprog:bool ufmec:string uframe:pose oframe:pose",
        "progdisp": "pdisp:pose eoffs:extjoint",
        "listitem": "image:string text:string",
        "tasks": "taskname:string",
        "wztemporary": "wz:num",
        "egm_minmax": "min:num max:num",
    }.items()
}
"""Components (type, name) of the records that come with the language."""

ALIASES = {
    **dict.fromkeys(("byte", "errnum", "intnum", "dionum", "socketstatus", "stoppoint"), "num"),
    **dict.fromkeys(("btnres", "buttondata", "icondata", "inttypes", "opnum", "symnum"), "num"),
    **dict.fromkeys(("identno", "tpnum", "egmframetype", "egmstate", "egmstopmode"), "num"),
    "errstr": "string",
    "wzstationary": "wztemporary",
}
"""Other names of types that come with the language."""


class Types:
    """Types of a program: those that come with the language, and its own records and aliases."""

    def __init__(self) -> None:
        """Begin with those that come with the language."""
        self.records, self.aliases = dict(RECORDS), dict(ALIASES)

    def resolved(self, name: str) -> str | None:
        """Return the name of a type without aliases, in small letters; None where there is none of that name."""
        name = name.lower()
        for _ in range(len(self.aliases) + 1):
            if name not in self.aliases:
                break
            name = self.aliases[name].lower()
        known = name in ATOMIC or name in self.records or name in SIGNALS or name in ("any", "switch")
        return name if known else None

    def names(self) -> list[str]:
        """Return all names, for those that are mistyped."""
        return [*ATOMIC, *self.records, *self.aliases, *SIGNALS]

    def components(self, name: str) -> list[tuple[str, str]]:
        """Return the components (type, name) of a record; none of other types."""
        return self.records.get(name, [])


def fits(value: Type, wanted: Type) -> bool:
    """Return whether a value of one type can be given where another is wanted."""
    if wanted.name == "any" or value.name == "any":
        return True
    if value.dimensions != wanted.dimensions:
        return False
    return value.name == wanted.name or (value.name in SIGNALS and wanted.name == "num")


def no_array(sizes: Sequence[float]) -> str:
    """Return why an array can't have these sizes; nothing where it can."""
    counts = [math.floor(size + 0.5) for size in sizes]
    if not counts or (min(counts) >= 1 and math.prod(counts) <= 1_000_000):
        return ""
    return f"an array has 1 to 1,000,000 elements, not {' times '.join(map(str, counts))}"
