"""Parameters of a study and the cells that they make: a grid of fixed values, and draws from laws at its points.

Everything follows from a cell's number and the study's seed, so cells may be made in any order, anywhere.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Value = int | float | str

RANDOM, SOBOL, SENSITIVITY = "random", "sobol", "sensitivity"
MOST_CELLS = 1_000_000_000
_SOBOL_BITS = 30


@dataclass(frozen=True)
class Values:
    """Parameter that takes each of some values: one direction of the grid."""

    name: str
    values: tuple[Value, ...]

    @property
    def is_text(self) -> bool:
        """True for texts, false for numbers."""
        return isinstance(self.values[0], str)


@dataclass(frozen=True)
class Law:
    """Parameter that is drawn from a law of `scipy.stats`, or evenly from a range, which is the law `uniform`."""

    name: str
    law: str
    settings: tuple[tuple[str, float], ...]
    is_text = False

    def quantiles(self, shares: Floats) -> list[Value]:
        """Return the values below which the law has these shares (n,), each in (0, 1)."""
        settings = dict(self.settings)
        if self.law == "uniform":
            low = settings.get("loc", 0.0)
            return [float(one) for one in low + settings.get("scale", 1.0) * shares]
        law = scipy_law(self.law)
        drawn = np.broadcast_to(np.asarray(law.ppf(shares, **settings), dtype=np.float64), shares.shape)
        return [int(one) if is_discrete(law) else float(one) for one in drawn]


@dataclass(frozen=True)
class Choice:
    """Parameter that a search chooses among some values."""

    name: str
    values: tuple[Value, ...]

    @property
    def is_text(self) -> bool:
        """True for texts, false for numbers."""
        return isinstance(self.values[0], str)

    def quantiles(self, shares: Floats) -> list[Value]:
        """Return the values at these shares (n,) of all of them, each in (0, 1)."""
        return [self.values[min(int(share * len(self.values)), len(self.values) - 1)] for share in shares.tolist()]


Parameter = Values | Law | Choice


@dataclass(frozen=True)
class Cells:
    """All cells of a study, by their numbers: those of the first point of the grid, then of the next.

    Attributes:
        parameters: in the order of the file; the last of those with fixed values changes first from point to point.
        draws: number of cells at each point of the grid.
        sampling: `random`, each cell by its own seed; `sobol`, the same scrambled Sobol sequence at each point; or
            `sensitivity`, at each point the matrices A, B and, for each law, A with its column of B, each of so many
            draws.
        seed: of the study, 0 to 2^64 - 1.
    """

    parameters: tuple[Parameter, ...]
    draws: int
    sampling: str
    seed: int

    @cached_property
    def fixed(self) -> list[Values]:
        """Parameters with fixed values."""
        return [one for one in self.parameters if isinstance(one, Values)]

    @cached_property
    def laws(self) -> list[Law | Choice]:
        """Parameters that are drawn."""
        return [one for one in self.parameters if not isinstance(one, Values)]

    @cached_property
    def constant(self) -> list[Values | Choice]:
        """Parameters that are the same in all cells."""
        return [one for one in self.parameters if not isinstance(one, Law) and len(one.values) == 1]

    @cached_property
    def count(self) -> int:
        """Number of cells."""
        return math.prod(len(one.values) for one in self.fixed) * self.per_point

    @property
    def per_point(self) -> int:
        """Number of cells at each point of the grid."""
        return self.draws * (len(self.laws) + 2 if self.sampling == SENSITIVITY else 1)

    def between(self, first: int, last: int) -> list[dict[str, Value]]:
        """Return the parameters of the cells from `first` up to but not with `last`, by name."""
        columns = {one.name: self._fixed(one, first, last) for one in self.fixed}
        if self.laws:
            shares = (self._random if self.sampling == RANDOM else self._sobol)(first, last)
            columns |= {law.name: law.quantiles(shares[:, column]) for column, law in enumerate(self.laws)}
        ordered = {one.name: columns[one.name] for one in self.parameters}
        return [{name: column[row] for name, column in ordered.items()} for row in range(last - first)]

    def point(self, number: int) -> dict[str, Value]:
        """Return the parameters with fixed values of one cell, by name."""
        return {one.name: self._fixed(one, number, number + 1)[0] for one in self.fixed}

    def _fixed(self, parameter: Values, first: int, last: int) -> Sequence[Value]:
        later = self.fixed[self.fixed.index(parameter) + 1 :]
        repeats = math.prod(len(one.values) for one in later) * self.per_point
        return [parameter.values[number // repeats % len(parameter.values)] for number in range(first, last)]

    def _random(self, first: int, last: int) -> Floats:
        """Return shares in (0, 1), a row for each cell.

        They come from another part of the cell's random numbers than those that the function draws.
        """
        bits = [generator(self.seed, number, 1).integers(0, 2**52, len(self.laws)) for number in range(first, last)]
        return (np.array(bits, dtype=np.float64) + 0.5) / 2**52

    def _sobol(self, first: int, last: int) -> Floats:
        from scipy.stats import qmc

        laws, rows, number = len(self.laws), [], first
        while number < last:
            matrix, begin = divmod(number % self.per_point, self.draws)
            count = min(last - number, self.draws - begin)
            scramble = np.random.default_rng(self.seed)
            sequence = qmc.Sobol(
                laws * (2 if self.sampling == SENSITIVITY else 1), scramble=True, bits=_SOBOL_BITS, rng=scramble
            )
            with warnings.catch_warnings():
                # A block needs not be a power of two; all draws together are.
                warnings.simplefilter("ignore")
                points = (sequence.fast_forward(begin) if begin else sequence).random(count)
            found = points[:, laws:] if matrix == 1 else points[:, :laws]
            if matrix > 1:
                found[:, matrix - 2] = points[:, laws + matrix - 2]
            rows.append(found)
            number += count
        return np.concatenate(rows) + 0.5 / 2**_SOBOL_BITS


def generator(seed: int, number: int, part: int = 0) -> np.random.Generator:
    """Return the random numbers of a cell: Philox by the study's seed and the cell's number.

    They depend on nothing else. Parts are 2^192 numbers apart. John Salmon et al., "Parallel random numbers: as easy as
    1, 2, 3", 2011.
    """
    key = np.array([seed, number], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=np.array([0, 0, 0, part], dtype=np.uint64)))


class _ScipyLaw(Protocol):
    """Law of one variable of `scipy.stats`, as far as it is used here; `shapes` are the names of its own settings."""

    shapes: str | None

    def ppf(self, q: Floats, **settings: float) -> Floats:
        """Return the values below which the law has the shares `q`; NaN where it can't have these settings."""
        ...


def scipy_law(name: str) -> _ScipyLaw:
    """Return a law of one variable of `scipy.stats`; raise ValueError, in words, where there is none."""
    from scipy import stats
    from virtualrobot._wire.names import nearest

    law = getattr(stats, name, None)
    if not isinstance(law, stats.rv_continuous | stats.rv_discrete):
        names = [one for one, law in vars(stats).items() if isinstance(law, stats.rv_continuous | stats.rv_discrete)]
        raise ValueError(f"scipy.stats has no law {name!r}; {nearest(name, names)}")
    return law


def is_discrete(law: _ScipyLaw) -> bool:
    """True for a law of whole numbers."""
    from scipy import stats

    return isinstance(law, stats.rv_discrete)


def check_law(law: str, settings: Mapping[str, float]) -> None:
    """Raise ValueError, in words, for a law that there is not, or that can't have these settings."""
    made = scipy_law(law)
    shapes = [one.strip() for one in (made.shapes or "").split(",") if one.strip()]
    known = [*shapes, "loc", *([] if is_discrete(made) else ["scale"])]
    if unknown := [name for name in settings if name not in known]:
        raise ValueError(f"the law {law!r} has no {unknown[0]!r}; it has {', '.join(known)}")
    if missing := [name for name in shapes if name not in settings]:
        raise ValueError(f"the law {law!r} needs {missing[0]!r}")
    if not np.isfinite(made.ppf(np.array([0.25, 0.75]), **settings)).all():
        said = ", ".join(f"{name} {value:g}" for name, value in settings.items())
        raise ValueError(f"there is no law {law!r} with {said}; scipy.stats.{law} tells what its values may be")


def check_deviations(parameters: Mapping[str, Any], *names: str) -> None:
    """Raise ValueError for the first of some parameters that is below 0, which no deviation or tolerance is."""
    for name in names:
        if (value := parameters.get(name, 0.0)) < 0.0:
            raise ValueError(f"{name} is 0 or more, not {value:g}")
