"""Coats: triangles on nodes, coloured by a value at each corner, that grow and change while somebody looks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message
from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import view_pb2

COLOR_MAPS = {
    "viridis": view_pb2.COLOR_MAP_VIRIDIS,
    "turbo": view_pb2.COLOR_MAP_TURBO,
    "heat": view_pb2.COLOR_MAP_HEAT,
}
"""Colours by name."""


@checked
class CoatHandle:
    """A coat of a node; `View.add_coat` makes one.

    Attributes:
        name: unique among the coats of a kernel.
        low: the quantity that has the first colour.
        high: that which has the last one.
    """

    def __init__(self, services: Services, name: str, low: float, high: float, corners: int) -> None:
        """Handle the coat `name`."""
        self._services = services
        self.name, self.low, self.high = name, low, high
        self._sent = np.zeros(corners, np.uint8)

    def paint(self, quantities: ArrayLike) -> None:
        """Show quantities (n,), one for each corner, in the legend's unit; NaN where there is nothing.

        Only corners whose colour has changed are sent, from the first to the last of them.
        """
        values = coat_bytes(quantities, self.low, self.high)
        if values.shape != self._sent.shape:
            raise InvalidArgumentError(f"the coat {self.name!r} has {len(self._sent)} corners, not {values.shape}")
        rows = np.flatnonzero(values != self._sent)
        if not len(rows):
            return
        first, end = int(rows[0]), int(rows[-1]) + 1
        given = view_pb2.CoatValues(name=self.name, first=first, values=values[first:end].tobytes())
        self._services.view.PaintCoat(view_pb2.PaintCoatRequest(values=given))
        self._sent = values

    def remove(self) -> None:
        """Take it away."""
        self._services.view.RemoveCoats(view_pb2.RemoveCoatsRequest(names=[self.name]))

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<CoatHandle {self.name!r}: {len(self._sent)} corners, {self.low:g} to {self.high:g}>"


def coat_bytes(quantities: ArrayLike, low: float, high: float) -> NDArray[np.uint8]:
    """Return a byte for each quantity: 1 (`low` and less) to 255 (`high` and more); 0 for NaN."""
    given = np.asarray(quantities, np.float64)
    there = ~np.isnan(given)
    parts = np.clip((np.where(there, given, low) - low) / (high - low), 0.0, 1.0)
    return np.where(there, 1.0 + np.rint(254.0 * parts), 0.0).astype(np.uint8)


def set_coat(services: Services, coat: view_pb2.Coat, vertices: ArrayLike, faces: ArrayLike) -> CoatHandle:
    """Put a coat on a node."""
    coat.vertices.CopyFrom(array_message(vertices, "<f4"))
    coat.faces.CopyFrom(array_message(faces, "<i4"))
    services.view.SetCoat(view_pb2.SetCoatRequest(coat=coat))
    return CoatHandle(services, coat.name, coat.low, coat.high, coat.vertices.shape[0])


def watch_coats(services: Services) -> Iterator[dict[str, NDArray[np.uint8]]]:
    """Yield the values of all coats by name, now and after changes."""
    found: dict[str, NDArray[np.uint8]] = {}
    with services.view.WatchCoats(view_pb2.WatchCoatsRequest()) as stream:
        for response in stream:
            found = {name: values for name, values in found.items() if name not in response.removed_names}
            found |= {coat.name: np.frombuffer(coat.values, np.uint8) for coat in response.coats}
            for part in response.values:
                values = found[part.name].copy()
                values[part.first : part.first + len(part.values)] = np.frombuffer(part.values, np.uint8)
                found[part.name] = values
            yield found


def color_map_of(name: str) -> view_pb2.ColorMap:
    """Return the number of colours; raises InvalidArgumentError for others."""
    if name not in COLOR_MAPS:
        raise InvalidArgumentError(f"{name!r} is no colour map; there are {', '.join(COLOR_MAPS)}")
    return COLOR_MAPS[name]
