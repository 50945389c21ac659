"""Bodies by Manifold: each word of the grammar, made.

Source of the library: Lalish, "Guaranteed-Manifold Mesh Boolean Algorithm", the package manifold3d (Apache 2.0).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import manifold3d
import msgspec
import numpy as np
from manifold3d import CrossSection, Manifold
from numpy.typing import NDArray
from virtualrobot_sdk.poses import from_roll_pitch_yaw, rotation_matrix

from virtualrobot_plugins.importers.solid import grammar

MAX_BODIES = 5_000
"""Number of bodies and profiles of a file; names that use each other could make any number."""

MAX_DEPTH = 100
MAX_TRIANGLES = 500_000
"""Number of triangles of one body."""

MAX_WORK = 5_000_000
"""Number of triangles of all bodies of a file together: what they come to takes memory and time."""

FEWEST_SIDES, MOST_SIDES = 12, 360


class Wrong(Exception):
    """A file says something that makes no body: where, and what would be right."""

    def __init__(self, place: str, said: str) -> None:
        """Say it of a place such as `solid.difference[1].cylinder`."""
        super().__init__(f"{place}: {said}" if place else said)


class Builder:
    """Makes the bodies of one file."""

    def __init__(self, named: dict[str, Any], tolerance: float) -> None:
        """Take the bodies that have names, and the tolerance of round things (m)."""
        self._named, self._tolerance = named, tolerance
        self._made = self._work = 0
        self._using: list[str] = []
        self._known: dict[str, Manifold] = {}

    def solid(self, wish: object, place: str, depth: int = 0) -> Manifold:
        """Return the body that is wished for at a place of the file."""
        word, value, place = self._word(wish, place, depth, grammar.SOLIDS, "a body")
        made = _MAKE[word](self, value, place, depth + 1)
        if (error := made.status()) != manifold3d.Error.NoError:
            raise Wrong(place, f"no body comes of it ({error.name})")
        count = made.num_tri()
        self._work += count
        if count > MAX_TRIANGLES:
            raise Wrong(place, f"it has {count} triangles; at most {MAX_TRIANGLES} are made: raise `tolerance`")
        if self._work > MAX_WORK:
            raise Wrong(place, f"all bodies together have more than {MAX_WORK} triangles: raise `tolerance`")
        return made

    def profile(self, wish: object, place: str, depth: int) -> CrossSection:
        """Return the profile that is wished for at a place of the file."""
        if isinstance(wish, list):
            wish = {"polygon": {"points": wish}}
        word, value, place = self._word(wish, place, depth, grammar.PROFILES, "a profile")
        made = _DRAW[word](self, value, place, depth + 1)
        if made.is_empty():
            raise Wrong(place, "the profile has no area")
        return made

    def solids(self, wishes: list[Any], place: str, depth: int) -> list[Manifold]:
        """Return several bodies."""
        return [self.solid(one, f"{place}[{number}]", depth) for number, one in enumerate(wishes)]

    def profiles(self, wishes: list[Any], place: str, depth: int) -> list[CrossSection]:
        """Return several profiles."""
        return [self.profile(one, f"{place}[{number}]", depth) for number, one in enumerate(wishes)]

    def used(self, name: str, place: str, depth: int) -> Manifold:
        """Return the body of a name, which is made once."""
        if name not in self._named:
            known = f"; there are {', '.join(sorted(self._named))}" if self._named else ""
            raise Wrong(place, f"there is no {name!r} among `solids`{known}")
        if name in self._using:
            raise Wrong(place, f"{' uses '.join(map(repr, [*self._using, name]))}, which has no end")
        if name not in self._known:
            self._using.append(name)
            self._known[name] = self.solid(self._named[name], f"solids.{name}", depth)
            self._using.pop()
        return self._known[name]

    def sides(self, radius: float) -> int:
        """Return the number of sides of a circle, a multiple of 4: its edges are as near as the tolerance says."""
        half = math.acos(max(1.0 - self._tolerance / radius, 0.0))
        return min(max(4 * math.ceil(math.pi / half / 4.0), FEWEST_SIDES), MOST_SIDES)

    def _word(self, wish: object, place: str, depth: int, words: dict[str, type], what: str) -> tuple[str, Any, str]:
        """Return the word of a wish, what it takes as its class, and the place of that."""
        self._made += 1
        if self._made > MAX_BODIES or depth > MAX_DEPTH:
            raise Wrong(place, f"the file has more than {MAX_BODIES} bodies, or more than {MAX_DEPTH} in each other")
        if not isinstance(wish, dict) or len(wish) != 1:
            raise Wrong(place, f"{what} is one of {', '.join(words)} with what it takes, not {_brief(wish)}")
        ((word, value),) = wish.items()
        if word not in words:
            raise Wrong(place, f"{word!r} is no word for {what}; there are {', '.join(words)}")
        place = f"{place}.{word}"
        return word, taken(value, words[word], place), place


def taken(value: object, kind: Any, place: str) -> Any:  # noqa: ANN401 an object of `kind`
    """Return a value of the file as a class of the grammar.

    Raises:
        Wrong: with the place, and what would be right.
    """
    names = getattr(kind, "__dataclass_fields__", None)
    if names is not None and isinstance(value, dict) and (unknown := [str(one) for one in value if one not in names]):
        raise Wrong(place, f"it takes {', '.join(names)}, not {', '.join(unknown)}")
    try:
        # Not strict: YAML 1.1 takes `1e-5` for a text.
        made = msgspec.convert(value, kind, strict=False)
    except msgspec.ValidationError as error:
        said, _, where = str(error).partition(" - at `$")
        raise Wrong((place + where.rstrip("`")).lstrip("."), said[:1].lower() + said[1:]) from None
    if isinstance(value, dict) and not all(map(_is_finite, value.values())):
        raise Wrong(place, "its numbers have to be finite")
    return made


def _is_finite(value: object) -> bool:
    """Return whether the numbers of a value are finite; bodies within it are looked at by themselves."""
    if isinstance(value, list):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _brief(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _unit(direction: tuple[float, float, float], place: str) -> NDArray[np.float64]:
    vector = np.array(direction)
    length = float(np.linalg.norm(vector))
    if not 1e-9 < length < 1e9:
        raise Wrong(place, f"a direction has a length, which {list(direction)} has not")
    return vector / length


def _moved(body: Manifold, turn: NDArray[np.float64], shift: NDArray[np.float64]) -> Manifold:
    return body.transform(np.column_stack([turn, shift]))


def _extrude(build: Builder, wish: grammar.Extrude, place: str, depth: int) -> Manifold:
    profile = build.profile(wish.profile, f"{place}.profile", depth)
    steps = math.ceil(abs(wish.twist) / 0.1)
    return profile.extrude(wish.height, steps, math.degrees(wish.twist), (wish.top, wish.top))


def _lathe(build: Builder, wish: grammar.Lathe, place: str, depth: int) -> Manifold:
    profile = build.profile(wish.profile, f"{place}.profile", depth)
    (_, _, right, _) = profile.bounds()
    if right <= 0.0:
        raise Wrong(f"{place}.profile", "all of it has x below 0: nothing is left to turn about z")
    sides = max(round(build.sides(right) * wish.angle / (2.0 * math.pi)), 3)
    # Manifold counts the sides of a whole turn.
    return profile.revolve(round(sides * 2.0 * math.pi / wish.angle), math.degrees(wish.angle))


def _move(build: Builder, wish: grammar.Move, place: str, depth: int) -> Manifold:
    body = build.solid(wish.solid, f"{place}.solid", depth)
    return _moved(body, from_roll_pitch_yaw(*wish.turn), np.array(wish.by))


def _mirror(build: Builder, wish: grammar.Mirror, place: str, depth: int) -> Manifold:
    body = build.solid(wish.solid, f"{place}.solid", depth)
    normal = _unit(wish.normal, f"{place}.normal")
    reflect = np.eye(3) - 2.0 * np.outer(normal, normal)
    other = _moved(body, reflect, 2.0 * (np.array(wish.point) @ normal) * normal)
    return body + other if wish.copy else other


def _row(build: Builder, wish: grammar.Row, place: str, depth: int) -> Manifold:
    body = build.solid(wish.solid, f"{place}.solid", depth)
    return _joined([body.translate(number * np.array(wish.step)) for number in range(wish.count)])


def _ring(build: Builder, wish: grammar.Ring, place: str, depth: int) -> Manifold:
    body = build.solid(wish.solid, f"{place}.solid", depth)
    axis, center = _unit(wish.axis, f"{place}.axis"), np.array(wish.center)
    is_whole = wish.angle >= 2.0 * math.pi - 1e-9
    between = wish.angle / max(wish.count if is_whole else wish.count - 1, 1)
    turns = [rotation_matrix(number * between * axis) for number in range(wish.count)]
    return _joined([_moved(body, turn, center - turn @ center) for turn in turns])


def _joined(bodies: list[Manifold]) -> Manifold:
    if len(bodies) * bodies[0].num_tri() > MAX_TRIANGLES:
        raise Wrong("", f"{len(bodies)} such bodies have more than {MAX_TRIANGLES} triangles")
    return Manifold.batch_boolean(bodies, manifold3d.OpType.Add)


def _boolean(kind: manifold3d.OpType) -> Callable[[Builder, list[Any], str, int], Manifold]:
    return lambda build, wishes, place, depth: Manifold.batch_boolean(build.solids(wishes, place, depth), kind)


def _flat_boolean(kind: manifold3d.OpType) -> Callable[[Builder, list[Any], str, int], CrossSection]:
    return lambda build, wishes, place, depth: CrossSection.batch_boolean(build.profiles(wishes, place, depth), kind)


def _cylinder(build: Builder, wish: grammar.Cylinder) -> Manifold:
    return Manifold.cylinder(wish.length, wish.radius, wish.radius, build.sides(wish.radius), True)


def _cone(build: Builder, wish: grammar.Cone) -> Manifold:
    sides = build.sides(max(wish.radius, wish.top))
    return Manifold.cylinder(wish.length, wish.radius, wish.top, sides, True)


def _circle(build: Builder, wish: grammar.Circle) -> CrossSection:
    return CrossSection.circle(wish.radius, build.sides(wish.radius)).translate(wish.center)


def _rectangle(build: Builder, wish: grammar.Rectangle, place: str) -> CrossSection:
    width, height = wish.size
    if 2.0 * wish.corner >= min(wish.size):
        raise Wrong(f"{place}.corner", f"it is below half of the shorter side, {0.5 * min(wish.size):g} m")
    inner = CrossSection.square((width - 2.0 * wish.corner, height - 2.0 * wish.corner), True)
    rounded = inner if wish.corner == 0.0 else _grown(build, inner, wish.corner, sharp=False)
    return rounded.translate(wish.center)


def _polygon(wish: grammar.Polygon) -> CrossSection:
    whole = CrossSection([np.array(wish.points)], manifold3d.FillRule.NonZero)
    if whole.is_empty() or whole.area() < 0.0:
        whole = CrossSection([np.array(wish.points[::-1])], manifold3d.FillRule.NonZero)
    for hole in wish.holes:
        whole = whole - _polygon(grammar.Polygon(hole))
    return whole


def _grown(build: Builder, profile: CrossSection, by: float, *, sharp: bool) -> CrossSection:
    join = manifold3d.JoinType.Miter if sharp else manifold3d.JoinType.Round
    return profile.offset(by, join, 10.0, build.sides(abs(by)))


def _offset(build: Builder, wish: grammar.Offset, place: str, depth: int) -> CrossSection:
    profile = build.profile(wish.profile, f"{place}.profile", depth)
    return profile if wish.by == 0.0 else _grown(build, profile, wish.by, sharp=wish.sharp)


_MAKE: dict[str, Callable[[Builder, Any, str, int], Manifold]] = {
    "box": lambda build, wish, place, depth: Manifold.cube(wish.size, True),
    "cylinder": lambda build, wish, place, depth: _cylinder(build, wish),
    "cone": lambda build, wish, place, depth: _cone(build, wish),
    "sphere": lambda build, wish, place, depth: Manifold.sphere(wish.radius, build.sides(wish.radius)),
    "extrude": _extrude,
    "lathe": _lathe,
    "move": _move,
    "scale": lambda build, wish, place, depth: build.solid(wish.solid, f"{place}.solid", depth).scale(wish.factors),
    "mirror": _mirror,
    "row": _row,
    "ring": _ring,
    "union": _boolean(manifold3d.OpType.Add),
    "difference": _boolean(manifold3d.OpType.Subtract),
    "intersection": _boolean(manifold3d.OpType.Intersect),
    "hull": lambda build, wishes, place, depth: Manifold.batch_hull(build.solids(wishes, place, depth)),
    "use": lambda build, name, place, depth: build.used(name, place, depth),
}

_DRAW: dict[str, Callable[[Builder, Any, str, int], CrossSection]] = {
    "circle": lambda build, wish, place, depth: _circle(build, wish),
    "rectangle": lambda build, wish, place, depth: _rectangle(build, wish, place),
    "polygon": lambda build, wish, place, depth: _polygon(wish),
    "offset": _offset,
    "union": _flat_boolean(manifold3d.OpType.Add),
    "difference": _flat_boolean(manifold3d.OpType.Subtract),
    "intersection": _flat_boolean(manifold3d.OpType.Intersect),
}
