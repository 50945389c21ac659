"""Report of a grade, as data and as text."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from virtualrobot_sdk.testing.examination import State

_WIDTH = 110


@dataclass(frozen=True, slots=True)
class Row:
    """One law on all chains.

    Attributes:
        law: its name.
        state: FAILED where it failed on any chain, NOT_TRIED where it was tried on none.
        tried: number of postures, cases or calls.
        worst: the worst deviations of all chains by their unit.
        said: the fault in words, by chain.
    """

    law: str
    state: State
    tried: int = 0
    worst: Mapping[str, float] = field(default_factory=dict)
    said: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Cost:
    """Duration of a call (µs), median and 99th percentile: in the component's own process, and asked from another."""

    method: str
    median: float
    p99: float
    worker_median: float
    worker_p99: float


@dataclass(frozen=True, slots=True)
class Solutions:
    """Number of solutions within limits, returned and existing, for some poses of a chain."""

    chain: str
    poses: int
    returned: int
    existing: int


@dataclass(frozen=True, slots=True)
class Report:
    """A component's grade.

    Attributes:
        component: as it was named.
        seed: the seed of all random postures.
        taken: the chains that it was made for.
        declined: those that it declined, with its reasons.
        rows: the laws in the order in which they were tried; the first is whether it can be made at all.
        solutions: by chain; none for a redundant arm, which has endlessly many.
        cost_chain: the chain that the cost was measured on; empty when there was none.
        cost: by method.
    """

    component: str
    seed: int
    taken: tuple[str, ...]
    declined: Mapping[str, str]
    rows: tuple[Row, ...]
    solutions: tuple[Solutions, ...] = ()
    cost_chain: str = ""
    cost: tuple[Cost, ...] = ()

    @property
    def passed(self) -> bool:
        """Return whether every law was kept."""
        return all(row.state is State.OK for row in self.rows)


def text(report: Report) -> str:
    """Return the report as tables for a terminal."""
    lines = [f"{report.component}, seed {report.seed}", ""]
    rows = [("law", "", "tried", "worst deviation")]
    rows += [(row.law, row.state.value, f"{row.tried:,}", _worst(row.worst)) for row in report.rows]
    lines += _aligned(rows, right=(2,))
    for row in report.rows:
        lines += _said(f"{row.law} ", row.said)
    if report.declined:
        lines += ["", "declined"]
        lines += _said("", report.declined)
    if report.solutions:
        lines += ["", "solutions returned"]
        table = [(f"  {s.chain}", f"{s.returned} of {s.existing}", f"for {s.poses} poses") for s in report.solutions]
        lines += _aligned(table, right=())
    if report.cost:
        lines += ["", f"cost of a call on {report.cost_chain}: median and 99th percentile"]
        table = [("", "in process", "p99", "in a worker", "p99")]
        table += [(f"  {c.method}", *map(_time, (c.median, c.p99, c.worker_median, c.worker_p99))) for c in report.cost]
        lines += _aligned(table, right=(1, 2, 3, 4))
    failed = [row.law for row in report.rows if row.state is State.FAILED]
    lines += ["", f"failed: {', '.join(failed)}" if failed else "all laws are kept"]
    return "\n".join(lines)


def _said(lead: str, by_chain: Mapping[str, str]) -> list[str]:
    """Return what was said, chains that have the same words together."""
    chains: dict[str, list[str]] = {}
    for chain, said in by_chain.items():
        chains.setdefault(said, []).append(chain)
    return [
        line
        for said, names in chains.items()
        for line in textwrap.wrap(
            f"{lead}{'on ' if lead else ''}{', '.join(names)}: {said}",
            _WIDTH,
            initial_indent="  ",
            subsequent_indent="    ",
            break_on_hyphens=False,
        )
    ]


def _worst(worst: Mapping[str, float]) -> str:
    return ", ".join(f"{value:.2g} {unit}" for unit, value in worst.items())


def _time(microseconds: float) -> str:
    return f"{microseconds:,.1f} us" if microseconds < 1e4 else f"{microseconds / 1e3:,.1f} ms"


def _aligned(rows: Sequence[Sequence[str]], right: Sequence[int]) -> list[str]:
    """Return rows as lines with aligned columns, those of `right` to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if place in right else cell.ljust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
