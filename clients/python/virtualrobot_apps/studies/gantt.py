"""Gantt charts of lines: what each machine does when, as a picture in SVG."""

from __future__ import annotations

import html
from collections.abc import Sequence

from virtualrobot_apps.studies.flow import BLOCKED, DOWN, WORK, Spell

COLORS = {WORK: "#4477aa", DOWN: "#ee6677", BLOCKED: "#ccbb44"}
_WIDTH, _LEFT, _ROW, _BAR = 800, 140, 24, 18
_TICKS = 10


def gantt(spells: Sequence[Spell], begin: float, end: float) -> str:
    """Return the chart of spells between two times (s): a row for each machine, in the order of the spells.

    Blue is work, red a repair and yellow a part that has no place to go; each bar says on being pointed at which part
    it is about. Raises ValueError when the end is not after the beginning.
    """
    if not begin < end:
        raise ValueError(f"a chart ends after it begins, and not from {begin:g} s to {end:g} s")
    rows = list(dict.fromkeys((spell.station, spell.machine) for spell in spells))
    order = list(dict.fromkeys(station for station, _ in rows))
    rows.sort(key=lambda row: (order.index(row[0]), row[1]))
    several = {station for station, machine in rows if machine > 0}
    scale, height = (_WIDTH - _LEFT) / (end - begin), _ROW * (len(rows) + 2)
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" width="{_WIDTH}" role="img">']
    for number, (station, machine) in enumerate(rows):
        name = html.escape(f"{station} {machine + 1}" if station in several else station)
        lines.append(f'<text x="0" y="{number * _ROW + 14}" font-size="13">{name}</text>')
    for spell in spells:
        first, last = max(spell.begin, begin), min(spell.end, end)
        if first < last:
            top = rows.index((spell.station, spell.machine)) * _ROW
            said = f"{spell.state}, part {spell.part}: {spell.begin:.1f} s to {spell.end:.1f} s"
            lines.append(
                f'<rect x="{_LEFT + (first - begin) * scale:.2f}" y="{top}" width="{(last - first) * scale:.2f}" '
                f'height="{_BAR}" fill="{COLORS[spell.state]}" stroke="white" stroke-width="0.5">'
                f"<title>{said}</title></rect>"
            )
    for tick in range(_TICKS + 1):
        at = begin + (end - begin) * tick / _TICKS
        anchor = "end" if tick == _TICKS else "middle"
        lines.append(
            f'<text x="{_LEFT + (at - begin) * scale:.1f}" y="{len(rows) * _ROW + 14}" font-size="11" '
            f'text-anchor="{anchor}">{at:.4g} s</text>'
        )
    for number, (state, color) in enumerate(COLORS.items()):
        left, top = _LEFT + 100 * number, (len(rows) + 1) * _ROW
        lines.append(f'<rect x="{left}" y="{top}" width="12" height="12" fill="{color}"/>')
        lines.append(f'<text x="{left + 18}" y="{top + 11}" font-size="12">{state}</text>')
    return "\n".join([*lines, "</svg>"])
