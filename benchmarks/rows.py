"""What a benchmark gives: rows of two measured values, their ratio, and the greatest ratio that the budget allows."""

from __future__ import annotations

from typing import NotRequired, TypedDict


class Row(TypedDict):
    """One result. `ratio` is ours over the peer's; smaller is better. No budget means told, not judged."""

    name: str
    ours: float | None
    peer: float | None
    peer_name: str
    unit: str
    ratio: float | None
    budget: float | None
    note: NotRequired[str]


def row(name: str, ours: float, peer: float, peer_name: str, unit: str, budget: float | None, note: str = "") -> Row:
    """Return a result."""
    result = Row(
        name=name,
        ours=ours,
        peer=peer,
        peer_name=peer_name,
        unit=unit,
        ratio=ours / peer if peer else None,
        budget=budget,
    )
    if note:
        result["note"] = note
    return result
