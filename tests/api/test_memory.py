"""Memory of a kernel in which worlds are loaded and cleared again and again."""

from __future__ import annotations

import sys

import pytest

from benchmarks.memory import measured

CYCLES, WARM = 80, 30


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no /proc tells a process's memory")
def test_loading_and_clearing_does_not_grow() -> None:
    """By more than the journal, which takes 5 MB. Measured: 5 to 7 MB; up and down by 100 with arenas without end."""
    before, after = measured(CYCLES, WARM)
    assert after - before < 25.0
