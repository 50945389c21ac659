"""Tell the slowest tests of a run, and their files: of pytest's JUnit files, as tables for docs/testing.md."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

COUNT = 40


def table(of: str, seconds: Iterable[tuple[str, float]]) -> None:
    """Print the slowest as a table."""
    print(f"| seconds | {of} |\n|---|---|")
    for name, spent in sorted(seconds, key=lambda pair: -pair[1])[:COUNT]:
        print(f"| {spent:.1f} | {name} |")


def main(files: Sequence[str]) -> None:
    """Print both tables."""
    tests: list[tuple[str, float]] = []
    seconds_of: defaultdict[str, float] = defaultdict(float)
    for file in files:
        for case in ElementTree.parse(file).iter("testcase"):
            place = str(case.get("classname")).removeprefix("tests.").replace(".", "/")
            spent = float(case.get("time", 0))
            tests.append((f"`{place}` {case.get('name')}", spent))
            seconds_of[f"`{place}`"] += spent
    table("test", tests)
    print()
    table("file", seconds_of.items())


if __name__ == "__main__":
    main(sys.argv[1:])
