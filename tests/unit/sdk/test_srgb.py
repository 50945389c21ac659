"""The curve of sRGB against values of IEC 61966-2-1 worked out by hand."""

import numpy as np
import pytest
from virtualrobot_sdk.srgb import from_linear, to_linear

PAIRS = [(0.0, 0.0), (0.02, 0.02 / 12.92), (0.04045, 0.0031308), (0.5, 0.21404114), (188 / 255, 0.50288646), (1.0, 1.0)]


def test_values_of_the_standard() -> None:
    color, light = np.array(PAIRS).T
    assert to_linear(color) == pytest.approx(light, abs=1e-7)
    assert from_linear(light) == pytest.approx(color, abs=1e-6)


def test_there_and_back(rng: np.random.Generator) -> None:
    color = rng.uniform(0.0, 1.0, (50, 4, 3))
    assert from_linear(to_linear(color)) == pytest.approx(color, abs=1e-12)


def test_what_lies_outside_is_cut_off() -> None:
    assert to_linear([-1.0, 2.0]).tolist() == [0.0, 1.0]
    assert from_linear([-1.0, 2.0]) == pytest.approx([0.0, 1.0])
