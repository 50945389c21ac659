"""Code and plugins of a kernel, loaded by being imported: once, for all kernels that are forked from here.

No thread is started, since none lives on in a fork.
"""

from __future__ import annotations

import gc
import os

os.environ["GRPC_VERBOSITY"] = "NONE"  # as `virtualrobot serve` sets it before it imports grpc

from virtualrobot_kernel import kernel, serve
from virtualrobot_kernel.compiling import compile_code
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_sdk.compiled.cache import make_ready

assert kernel and serve, "it imports all rooms"
compile_code()
Catalog().load()
make_ready(lambda: False)
gc.collect()
gc.freeze()
