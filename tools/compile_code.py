"""Compiles what a kernel and its plugins compile at their first start, so that tests begin with it done."""

from __future__ import annotations

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.serve import compile_all_code

if __name__ == "__main__":
    Catalog()  # imports the bundled plugins, whose code is compiled too
    compile_all_code()
