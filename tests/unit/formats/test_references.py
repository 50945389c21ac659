"""Names of materials are found wherever they stand, as by a pattern that is tried at each line."""

from __future__ import annotations

import re
from unittest import mock

import numpy as np
from virtualrobot_kernel.formats import references
from virtualrobot_kernel.formats.references import list_references

from tests.tiers import Draws

WORDS = (
    "mtllib",
    "MTLLIB",
    "MtlLib",
    "usemtl",
    " ",
    "\t",
    "\n",
    "\r\n",
    "m",
    "M",
    "a b.mtl",
    "x\\y.mtl",
    "mtllibmtllib",
    "v 1 2",
)


def by_pattern(data: bytes) -> list[str]:
    """Return what follows each mtllib at the start of a line."""
    found = re.findall(rb"(?im)^[ \t]*mtllib[ \t]([^\r\n]*)", data)
    names = [one.decode("utf-8", "replace").strip().replace("\\", "/") for one in found]
    return list(dict.fromkeys(name for name in names if name))


def test_names_are_those_of_a_pattern(rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(2000)):
        data = "".join(WORDS[i] for i in rng.integers(0, len(WORDS), rng.integers(1, 40))).encode()
        few = list(list_references(data, "a.obj"))
        assert few == by_pattern(data), data
        with mock.patch.object(references, "MOST_LETTERS", 0):
            assert list(list_references(data, "a.obj")) == few
