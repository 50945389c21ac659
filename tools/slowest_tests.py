"""Tell the slowest tests of a run: of pytest's JUnit file, as a table for docs/testing.md."""

from __future__ import annotations

import sys
from xml.etree import ElementTree

COUNT = 40


def main(file: str) -> None:
    """Print the table."""
    cases = [(float(case.get("time", 0)), case) for case in ElementTree.parse(file).iter("testcase")]
    print("| seconds | test |\n|---|---|")
    for seconds, case in sorted(cases, key=lambda pair: -pair[0])[:COUNT]:
        place = str(case.get("classname")).removeprefix("tests.").replace(".", "/")
        print(f"| {seconds:.1f} | `{place}` {case.get('name')} |")


if __name__ == "__main__":
    main(sys.argv[1])
