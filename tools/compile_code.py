"""Compiles what a kernel and its plugins compile at their first start, so that tests begin with it done."""

from __future__ import annotations

from virtualrobot_kernel.compiling import compile_code
from virtualrobot_kernel.components.catalog import Catalog

if __name__ == "__main__":
    catalog = Catalog()  # imports the bundled plugins where their code is not compiled yet
    compile_code()
    catalog.remember()
