"""Motions that overlap: before one has stopped at a corner the next one starts, as on robot controllers.

Between the moment when the first motion is left and the one when the second is joined, all joints follow quintics in
time that begin and end with the position, velocity and acceleration of the two. The whole is again one path and one law
along it: the path piece of a quintic has a parameter of its own, on which a law runs that fits those on both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from virtualrobot_kernel.motion.path import quintic_hermite
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial, joined

#: Shares of what is allowed of both motions, and of the time that they take one after the other, that are tried.
_SHARES = np.geomspace(1.0, 0.05, 12)
_SHORTER = np.linspace(0.98, 0.3, 35)
_LOOKS = 33
#: Greatest number that is checked for fitting, and their distance in time, in steps of those that are tried.
_MOST_ASKED, _APART = 20, 3
#: Shares of velocity, acceleration and jerk limits that a quintic may take at its samples: what is left is for what
#: lies between. An acceleration that is at its limit when the first motion is left cannot be less.
_USED = (0.999, 1.0 + 1e-9, 0.985)
#: Knots of the path piece of a quintic, in each of the phases of its law: at first, and how often the time between two
#: is halved where the jerk is not yet within this share of the greatest.
_KNOTS, _HALVINGS, _EXACT = 6, 6, 2e-3
_BETWEEN = np.array([0.01, 0.3, 0.7, 0.99])
#: Shorter parts of a motion (s) between two overlaps are left out.
_SHORTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Overlap:
    """Transition from one motion into the next without a stop.

    The first is left `leave` s before its end, the second joined `join` s after its start, and in between the joints
    follow `quintic`, a function of time from 0 on.
    """

    leave: float
    join: float
    quintic: PiecewisePolynomial

    @property
    def saved(self) -> float:
        """Time (s) by which the whole is shorter than with a stop."""
        return self.leave + self.join - self.quintic.end


def overlap(
    before: Track,
    after: Track,
    leave: float,
    join: float,
    limits: Array,
    fits: Callable[[PiecewisePolynomial], bool],
) -> Overlap | None:
    """Return the overlap that saves most time, of many that are tried; None when none fits.

    leave, join: the longest that may be left out at the end of the first motion and the beginning of the second, in s.
    limits (3, n): velocity, acceleration and jerk of the joints, infinite where there is none. fits: what else a
    quintic has to satisfy; it is asked for the best ones in turn.
    """
    first = before.derivatives(before.time_law.end - leave * _SHARES)[:3]
    second = after.derivatives(join * _SHARES)[:3]
    together = (leave + join) * _SHARES[:, None] * _SHORTER
    x = np.linspace(0.0, 1.0, _LOOKS)
    powers = x[:, None] ** np.arange(6)
    coefficients = _unit_quintics(first, second, together)
    fitting = np.ones(together.shape, dtype=bool)
    for order in range(1, 4):
        factors = np.array([np.prod(range(k - order + 1, k + 1)) for k in range(order, 6)], dtype=np.float64)
        values = np.einsum("xk,knfr->nfrx", powers[:, : 6 - order] * factors, coefficients[order:])
        peaks = np.abs(values).max(axis=3) / together**order
        fitting &= np.all(peaks <= _USED[order - 1] * limits[order - 1][:, None, None], axis=0)
    saved = np.where(fitting, (leave + join) * _SHARES[:, None] - together, -np.inf)
    asked: dict[int, int] = {}
    left = _MOST_ASKED
    for place in np.argsort(-saved, axis=None).tolist():
        share, shorter = divmod(place, len(_SHORTER))
        if saved[share, shorter] <= 0.0 or not left:
            break
        # What is hardly slower than something that doesn't fit hardly fits either.
        if asked.get(share, shorter + _APART) - shorter < _APART:
            continue
        asked[share], left = shorter, left - 1
        ends = np.stack([first[:, share], second[:, share]], axis=1)
        quintic = quintic_hermite(np.array([0.0, together[share, shorter]]), *ends)
        if fits(quintic):
            return Overlap(leave * float(_SHARES[share]), join * float(_SHARES[share]), quintic)
    return None


def overlapped(tracks: Sequence[Track], overlaps: Sequence[Overlap]) -> tuple[Track, list[tuple[float, float]]]:
    """Return m motions of the same joints as one, with m - 1 overlaps; and from when to when these last, in s."""
    tracks = [_in_seconds(track) for track in tracks]
    paths: list[PiecewisePolynomial] = []
    laws: list[PiecewisePolynomial] = []
    windows = []
    s = now = 0.0
    for place, track in enumerate(tracks):
        law = track.time_law
        begin = overlaps[place - 1].join if place else law.start
        end = law.end - (overlaps[place].leave if place < len(overlaps) else 0.0)
        if end - begin > _SHORTEST:
            part = law.between(begin, end)
            first, last = part.scalar_state(begin)[0], part.scalar_state(end)[0]
            paths.append(shifted(track.path.between(first, last), s - first))
            laws.append(shifted(raised(part, s - first), now - begin))
            s, now = paths[-1].end, laws[-1].end
        if place == len(overlaps):
            break
        one = overlaps[place]
        following = tracks[place + 1].time_law
        phases = _phases(law.scalar_state(law.end - one.leave), following.scalar_state(one.join), one.quintic.end)
        path = _by_law(one.quintic, phases)
        paths.append(shifted(path, s))
        laws.append(shifted(raised(phases, s), now))
        windows.append((now, now + phases.end))
        s, now = paths[-1].end, laws[-1].end
    return Track(joined(paths), joined(laws)), windows


def _unit_quintics(first: Array, second: Array, seconds: Array) -> Array:
    """Return coefficients (6, n, F, R) of quintics in x in [0, 1] between states (3, F, n), for durations (F, R)."""
    (q0, v0, a0), (q1, v1, a1) = (state.transpose(0, 2, 1)[..., None] for state in (first, second))
    v0, v1, a0, a1 = v0 * seconds, v1 * seconds, a0 * seconds**2, a1 * seconds**2
    rise = np.broadcast_to(q1 - q0, v0.shape)
    return np.stack(
        [
            np.broadcast_to(q0, v0.shape),
            v0,
            a0 / 2.0,
            10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
            -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
            6.0 * rise - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1,
        ]
    )


def _phases(entry: tuple[float, float, float], exit: tuple[float, float, float], seconds: float) -> PiecewisePolynomial:
    """Return a law s(t) from 0 with the rate and slope of two states at its ends, whose rate never gets to 0: cubics.

    Each slope is brought to 0 within a third of the time, and before the rate is half of what it was; the rates that
    are reached so are joined by a ramp of two parabolas.
    """
    (_, rate0, slope0), (_, rate1, slope1) = entry, exit
    first, last = (
        min(seconds / 3.0, rate / abs(slope)) if slope else seconds / 3.0
        for rate, slope in ((rate0, slope0), (rate1, slope1))
    )
    low, high = rate0 + 0.5 * slope0 * first, rate1 - 0.5 * slope1 * last
    half = 0.5 * (seconds - first - last)
    jerk = (high - low) / half**2
    times = (first, half, half, last)
    jerks = (-slope0 / first, jerk, -jerk, slope1 / last)
    breaks, pieces = [0.0], []
    s, rate, slope = 0.0, rate0, slope0
    for time, third in zip(times, jerks, strict=True):
        pieces.append([s, rate, slope / 2.0, third / 6.0])
        s += time * (rate + time * (slope / 2.0 + time * third / 6.0))
        rate += time * (slope + time * third / 2.0)
        slope += time * third
        breaks.append(breaks[-1] + time)
    breaks[-1] = seconds
    return PiecewisePolynomial(np.array(breaks), np.array(pieces)[:, :, None])


def _by_law(quintic: PiecewisePolynomial, law: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return the path q(s) on which the law s(t) gives the function q(t), exactly so at its knots.

    dq/ds = q' / s' and d2q/ds2 = (q'' - dq/ds s'') / s'^2. Knots are added until the third derivative by time, too, is
    what it was: where the law gets much faster within a short time, a few do not tell.
    """
    steps = np.arange(_KNOTS) / _KNOTS
    times = np.append((law.breaks[:-1, None] + np.diff(law.breaks)[:, None] * steps).ravel(), law.end)
    allowed = _EXACT * np.abs(quintic.states(times, 3)[3]).max()
    for _ in range(_HALVINGS):
        path = _through(quintic, law, times)
        inside = times[:-1] + np.diff(times) * _BETWEEN[:, None]
        off = np.abs(Track(path, law).derivatives(inside.ravel())[3] - quintic.states(inside.ravel(), 3)[3]).max(axis=1)
        rough = (off.reshape(inside.shape) > allowed).any(axis=0)
        if not rough.any():
            break
        times = np.sort(np.concatenate([times, 0.5 * (times[:-1] + times[1:])[rough]]))
    return _through(quintic, law, times)


def _through(quintic: PiecewisePolynomial, law: PiecewisePolynomial, times: Array) -> PiecewisePolynomial:
    s, s1, s2 = law.states(times, 2)
    q, q1, q2 = quintic.states(times, 2)
    rate = q1 / s1
    return quintic_hermite(s[:, 0], q, rate, (q2 - rate * s2) / s1**2)


def _in_seconds(track: Track) -> Track:
    """Return the same motion with a path parameter that grows by 1 a second on average.

    A law from one motion's rate to another's is as smooth as the motions only where these have alike parameters.
    """
    path, law = track.path, track.time_law
    seconds = law.end - law.start
    scale = seconds / (path.end - path.start)
    scaled = PiecewisePolynomial(law.breaks, scale * law.coefficients)
    return Track(path.onto(0.0, seconds), raised(scaled, -scale * path.start))


def shifted(function: PiecewisePolynomial, by: float) -> PiecewisePolynomial:
    """Return a function whose parameter is greater by a constant."""
    return PiecewisePolynomial(function.breaks + by, function.coefficients)


def raised(function: PiecewisePolynomial, by: float) -> PiecewisePolynomial:
    """Return a function whose values are greater by a constant."""
    coefficients = function.coefficients.copy()
    coefficients[:, 0] += by
    return PiecewisePolynomial(function.breaks, coefficients)
