"""Lengths of errors: how far off something is at most, by the covariance of where it is."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError


def length_of(covariance: NDArray[np.float64], share: float = 0.95) -> float:
    """Return the length (m) that a normal vector of mean 0 and this covariance (3, 3), m^2, keeps in a share of cases.

    Its square is nearly a chi-squared number of the same mean and variance (Satterthwaite, An Approximate Distribution
    of Estimates of Variance Components, 1946), whose quantile is that of Wilson and Hilferty (The Distribution of
    Chi-Square, 1931): good to some percent.
    """
    if not 0.0 < share < 1.0:
        raise InvalidArgumentError(f"the share is {share:g}; it lies between 0 and 1, such as 0.95")
    sizes = np.linalg.eigvalsh(covariance)
    freedom = float(np.sum(sizes)) ** 2 / float(np.sum(sizes**2))
    part = 2.0 / (9.0 * freedom)
    quantile = max(1.0 - part + NormalDist().inv_cdf(share) * math.sqrt(part), 0.0) ** 3
    return math.sqrt(float(np.sum(sizes)) * quantile)
