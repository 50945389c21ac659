"""Lines of stations: how many parts an hour they finish, and what that earns.

For a study file: `function: virtualrobot_apps.studies.line:produce` or `:earn`,
`setup: virtualrobot_apps.studies.line_file:open_line`, `scene: LINE.yaml`.
"""

from __future__ import annotations

from virtualrobot_apps.studies.economy import earnings
from virtualrobot_apps.studies.flow import Flow, flow
from virtualrobot_apps.studies.line_file import Line, LineFile
from virtualrobot_apps.studies.work import Cell


def produce(cell: Cell) -> dict[str, float | str | None]:
    """Return what a line does in some hours, as one draw of chance has it.

    Its parameters: `hours`, the time (h) that counts; `warm_up`, the time (h) before it (without it, 0), in which the
    line, empty at first, fills; and all that the line file names.

    Its results: `throughput`, parts that are finished in an hour; `lead_time`, their mean time in the line (s), None
    where none was finished; `inside`, the mean number of parts in it; `scrapped`, waste in an hour; `bottleneck`, the
    station whose machines work or are repaired most of the time.
    """
    return _told(_run(cell)[1])


def earn(cell: Cell) -> dict[str, float | str | None]:
    """Return what `produce` does, and what the line earns with it.

    Besides: `investment`; `piece_cost`, what a finished piece costs with its share of the investment, None where there
    is none; `surplus` of a year; `payback`, the years until the surplus has brought the investment back, None where it
    never does; `present_value`, of the surplus of all years less the investment.
    """
    line, found = _run(cell)
    if line.money is None:
        raise ValueError("the line file doesn't say what it costs: `money` with hours, revenue and years")
    earned = earnings(line.money, found.throughput, found.throughput + found.waste)
    return _told(found) | {"investment": line.money.investment} | vars(earned)


def _run(cell: Cell) -> tuple[Line, Flow]:
    file: LineFile = cell.shared
    line = file.line(cell.parameters)
    hours, warm_up = cell.parameters["hours"], cell.parameters.get("warm_up", 0.0)
    if not hours > 0.0 or warm_up < 0.0:
        raise ValueError(f"hours are above 0 and warm_up is not below 0, not {hours:g} and {warm_up:g}")
    return line, flow(line.stations, cell.rng, 3600.0 * hours, 3600.0 * warm_up, line.source)


def _told(found: Flow) -> dict[str, float | str | None]:
    times = found.lead_times
    return {
        "throughput": found.throughput,
        "lead_time": sum(times) / len(times) if times else None,
        "inside": found.inside,
        "scrapped": found.waste,
        "bottleneck": found.bottleneck,
    }
