"""Money that a line earns: what a piece costs, and when the investment is back."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Money:
    """Costs and revenue of a line, in any one currency.

    Attributes:
        investment: once, for all stations.
        hours: that it runs in a year.
        running: cost of an hour: wages, energy, room, maintenance.
        material: cost of a piece that is begun.
        revenue: for a piece that is finished.
        interest: of a year, such as 0.05.
        years: after which the investment is worth nothing.
    """

    investment: float
    hours: float
    running: float
    material: float
    revenue: float
    interest: float
    years: float


@dataclass(frozen=True)
class Earnings:
    """Earnings of a line.

    Attributes:
        piece_cost: of a piece that is finished, with its share of the investment and of interest; None without any.
        surplus: of a year, before the investment is written off.
        payback: years until the surplus has brought the investment back; None where it never does.
        present_value: of the surplus of all years less the investment: above 0 it earns more than the interest.
    """

    piece_cost: float | None
    surplus: float
    payback: float | None
    present_value: float


def annuity(interest: float, years: float) -> float:
    """Return the share of an investment that is due each year: i / (1 - (1 + i)^-n), without interest 1/n."""
    return interest / (1.0 - (1.0 + interest) ** -years) if interest > 0.0 else 1.0 / years


def earnings(money: Money, finished: float, begun: float) -> Earnings:
    """Return what a line earns that finishes, and begins, so many pieces an hour.

    Payback is that of the static method; costs of a piece are by annuities.
    """
    running = money.hours * (money.running + money.material * begun)
    due = annuity(money.interest, money.years)
    pieces = finished * money.hours
    surplus = pieces * money.revenue - running
    return Earnings(
        (money.investment * due + running) / pieces if pieces else None,
        surplus,
        money.investment / surplus if surplus > 0.0 else None,
        surplus / due - money.investment,
    )
