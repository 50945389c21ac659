"""Threads of libraries for linear algebra: one in each process of a study, so that sums come out equal to the bit."""

from __future__ import annotations

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
"""Variables of a process's environment by which libraries take one thread each, as they are loaded."""
