"""Jobs for collision processes that do what a job may and may not do; imported in the processes."""

from __future__ import annotations

import ctypes
import os
import time

import numpy as np
from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.collision.site import Site
from virtualrobot_kernel.errors import LimitError

PATH = f"{__name__}:"


def touching(site: Site) -> dict[str, object]:
    """Return what touches and where all nodes are, and whose process this is."""
    pairs = [(pair.first, pair.second) for pair in site.scene.collisions(Detail.PAIRS)]
    return {"pid": os.getpid(), "pairs": pairs, "poses": site.snapshot.world_t_node, "scene": id(site.scene.bodies)}


def echoes(site: Site, value: object) -> object:
    """Return what it is given."""
    return value


def counts_until_given_up(site: Site) -> None:
    """Report numbers until nobody waits."""
    number = 0
    while True:
        number += 1
        site.told((os.getpid(), number))
        site.go_on()
        time.sleep(0.001)


def never_asks(site: Site) -> None:
    """Report once, and then neither ask nor end."""
    site.told(os.getpid())
    while True:
        time.sleep(0.01)


def holds_the_lock(site: Site) -> None:
    """Hold the interpreter's lock for a day."""
    ctypes.PyDLL(None).sleep(86_400)


def dies(site: Site) -> None:
    """End the process as a crash would."""
    os.abort()


def refuses(site: Site) -> None:
    """Refuse as the kernel does."""
    raise LimitError("7 is too much; 5 is the most", value=7)


def breaks(site: Site) -> float:
    """Have a bug."""
    return 1 / len(np.zeros(0))


def returns_a_class(site: Site) -> object:
    """Return what may not travel."""
    return site.snapshot.state
