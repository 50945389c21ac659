"""Heat map of contacts: where a contact sensor feels, and how much, in cells of the world."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, Figure, Reading, UnknownNameError
from virtualrobot.scene.figures import points

Floats = NDArray[np.float64]

DRAWN_SECONDS = 0.25
"""Simulation time (s) from one drawing to the next."""
COLD, WARM, HOT = (40, 70, 160), (250, 210, 60), (200, 30, 30)
"""Colours (0 to 255) of nothing, of half and of the greatest value."""


class HeatMap:
    """Sums over cells: impulses (N s) of contacts whose force is known, and times (s) of those that only touch."""

    def __init__(self, cell: float) -> None:
        """Begin with nothing; `cell` is the edge of a cell (m)."""
        self.cell = cell
        self.readings = 0
        self.has_forces = False
        self._sums: dict[tuple[int, int, int], float] = {}
        self._last: float | None = None

    def add(self, reading: Reading) -> None:
        """Add the contacts of a reading, for the time since the one before; the first one only begins."""
        now = reading.stamp.simulation_time
        seconds, self._last = 0.0 if self._last is None else now - self._last, now
        self.readings += 1
        for contact in reading.value or ():
            if contact.distance > 0.0:
                continue
            weight = 1.0
            if contact.force is not None:
                self.has_forces, weight = True, float(np.linalg.norm(contact.force))
            i, j, k = np.floor(contact.point / self.cell).astype(int).tolist()
            self._sums[i, j, k] = self._sums.get((i, j, k), 0.0) + weight * seconds

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return "N s" if self.has_forces else "s"

    @property
    def places(self) -> Floats:
        """(n, 3) middles of the cells in the world (m)."""
        return (np.array(list(self._sums), float).reshape(-1, 3) + 0.5) * self.cell

    @property
    def values(self) -> Floats:
        """(n,) what came together in each."""
        return np.array(list(self._sums.values()), float)

    def figure(self) -> Figure:
        """Return the cells as points, coloured from blue to red."""
        return points(self.places, colors=colors(self.values), size=self.cell)

    def picture(self) -> str:
        """Return an SVG of the cells from above, those above each other added up; x to the right, y up, in m."""
        columns: dict[tuple[int, int], float] = {}
        for (i, j, _), value in self._sums.items():
            columns[i, j] = columns.get((i, j), 0.0) + value
        at = np.array(list(columns)).reshape(-1, 2)
        low, high = at.min(axis=0) - 1, at.max(axis=0) + 2
        edge = 480.0 / max(int((high - low).max()), 1)
        width, height = edge * (high - low)
        greatest = max(columns.values())
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width + 40:.0f} {height + 60:.0f}" '
            'font-family="sans-serif" font-size="12">',
            f'<rect width="100%" height="100%" fill="white"/><text x="20" y="20">contacts, at most {greatest:.3g} '
            f"{self.unit} in a cell of {1e3 * self.cell:g} mm</text>",
        ]
        shades = colors(np.array(list(columns.values())))
        for (i, j), (red, green, blue) in zip(columns, shades.tolist(), strict=True):
            x, y = 20 + edge * (i - low[0]), 30 + height - edge * (j + 1 - low[1])
            where = f'x="{x:.1f}" y="{y:.1f}" width="{edge:.1f}" height="{edge:.1f}"'
            parts.append(f'<rect {where} fill="rgb({red},{green},{blue})"/>')
        ends = [f"{low[axis] * self.cell:.3g} to {high[axis] * self.cell:.3g}" for axis in (0, 1)]
        parts.append(f'<text x="20" y="{height + 50:.0f}">x {ends[0]} m, y {ends[1]} m</text>')
        return "\n".join([*parts, "</svg>\n"])

    def told(self) -> str:
        """Return the line about it for people."""
        if not self._sums:
            return f"{self.readings} readings, and nothing touched"
        hottest = int(np.argmax(self.values))
        x, y, z = self.places[hottest].tolist()
        return (
            f"{self.readings} readings, {len(self._sums)} cells, {self.values.sum():.4g} {self.unit} in all; most, "
            f"{self.values[hottest]:.4g} {self.unit}, at {x:.3f}, {y:.3f}, {z:.3f}"
        )


def colors(values: Floats) -> NDArray[np.uint8]:
    """Return the colour (n, 3) of each value, from 0 to the greatest."""
    part = values / max(float(values.max(initial=0.0)), 1e-300)
    ramp = np.array([COLD, WARM, HOT], float)
    return np.stack([np.interp(part, (0.0, 0.5, 1.0), ramp[:, axis]) for axis in range(3)], axis=1).astype(np.uint8)


def gathered(client: Client, sensor: str, cell: float, seconds: float | None) -> HeatMap:
    """Return the map of what a contact sensor feels for some simulation time, or until Ctrl-C.

    It is drawn meanwhile, as the annotation "heat of SENSOR", which stays.

    Raises:
        UnknownNameError: when there is no contact sensor of that name.
    """
    kinds = {node.name: node.kind for node in client.scene.nodes()}
    if kinds.get(sensor) != "contact_sensor":
        there = ", ".join(name for name, kind in kinds.items() if kind == "contact_sensor") or "none"
        raise UnknownNameError(f"there is no contact sensor named {sensor!r}; there is {there}")
    name, found, begin, drawn = f"heat of {sensor}", HeatMap(cell), None, -1.0
    node = client.scene[name] if name in kinds else client.scene.add_annotation(name, ())
    with _running(client, sensor), suppress(KeyboardInterrupt):
        for reading in client.sensors[sensor].watch():
            now = reading.stamp.simulation_time
            begin = now if begin is None else begin
            found.add(reading)
            if now - drawn >= DRAWN_SECONDS and len(found.values):
                node.set_figures([found.figure()])
                drawn = now
            if seconds is not None and now - begin >= seconds:
                break
    node.set_figures([found.figure()])
    return found


@contextmanager
def _running(client: Client, sensor: str) -> Iterator[None]:
    """Let a sensor read, and no more afterwards where it stood before."""
    stood = client.sensors[sensor].status.state != "running"
    if stood:
        client.sensors[sensor].start()
    try:
        yield
    finally:
        if stood:
            client.sensors[sensor].stop()
