"""Ray cluster as an engine: blocks are its tasks, and their parts are written where they are done.

So all its nodes see the study's files and its folder, if that is in no bucket, at the same paths, and have the same
packages. Nothing else goes
from node to node, and what Ray forgets as a node dies is in the folder already.
"""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import grpc
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.studies.engines import Ends, Lost
from virtualrobot_apps.studies.threads import ONE_THREAD
from virtualrobot_apps.studies.work import Block, Job, work

OWN = "local"
"""Address of a cluster on this machine that is started for the study, and ends with it."""
_LOOK_SECONDS = 1.0
"""Time (s) after which it is looked whether nodes have joined."""
_QUIET = {"log_to_driver": False, "logging_level": logging.WARNING}
_KNOCK_SECONDS = 10.0
"""Time (s) in which a cluster's head is to take a connection."""


class Ray:
    """Cluster of Ray, each core of which does a block; another one may be queued, so that none has to wait."""

    def __init__(self, address: str = OWN, workers: int | None = None) -> None:
        """Join a cluster, or start one.

        Args:
            address: `local` for one of its own on this machine, `ray://HOST:PORT` from anywhere, `HOST:PORT` or `auto`
                from one of its nodes.
            workers: number of blocks that are done at once; that of the cluster's cores by default.

        Raises:
            WrongStateError: when Ray isn't installed, or there is no such cluster.
        """
        try:
            import ray  # pyright: ignore[reportMissingImports]  as few have it
        except ImportError as error:
            raise WrongStateError("a Ray cluster needs Ray: pip install 'virtualrobot[ray]'") from error
        self._ray: Any = ray
        self._address, self._most = address, workers
        if ray.is_initialized():
            raise WrongStateError("this process is at a Ray cluster already: leave it by `ray.shutdown()`")
        before = dict(os.environ)
        try:
            if address == OWN:
                os.environ.update(ONE_THREAD)
                self._ray.init(address=OWN, num_cpus=workers, include_dashboard=False, **_QUIET)
            else:
                knock(address)
                self._ray.init(address=address, **_QUIET)
        except (OSError, RuntimeError, ValueError) as error:
            raise WrongStateError(f"no Ray cluster answers at {address}: {error}") from error
        finally:
            for name in ONE_THREAD:
                os.environ.pop(name, None)
                if name in before:
                    os.environ[name] = before[name]
        self.workers = self._cores()

    def run(self, job: Job, following: Callable[[], Block | None]) -> Ends:
        """Do blocks side by side. It leaves the cluster with the iterator, which ends what is running.

        No task is cancelled by itself: Ray 2.60 aborts this process when one ends at that moment.
        """
        exceptions = self._ray.exceptions
        # A task that is lost isn't done again by Ray: the block is to be halved.
        task = self._ray.remote(num_cpus=1, max_retries=0)(work)
        if isinstance(job.folder, Path):
            job = replace(job, folder=job.folder.absolute())
        running: dict[Any, Block] = {}
        try:
            while True:
                while len(running) < self._at_once() and (block := following()) is not None:
                    running[task.remote(job, block, True)] = block
                if not running:
                    return
                ended, _ = self._ray.wait(list(running), num_returns=1, timeout=_LOOK_SECONDS)
                for one in ended:
                    block = running.pop(one)
                    try:
                        answer = self._ray.get(one)
                    except exceptions.RayTaskError as error:
                        raise error.cause from None
                    except exceptions.RayError as error:
                        answer = Lost(" ".join(f"{type(error).__name__}: {error}".split()))
                    yield block, answer
        except (ConnectionError, grpc.RpcError) as error:
            details = getattr(error, "details", None)
            said = error if details is None else details()
            raise WrongStateError(
                f"the Ray cluster at {self._address} has gone: {said}; what is done stays, and 'virtualrobot study "
                "resume' goes on, there or elsewhere"
            ) from error
        finally:
            self._ray.shutdown()

    def _cores(self) -> int:
        cores = max(1, int(self._ray.cluster_resources().get("CPU", 1)))
        return cores if self._most is None else min(self._most, cores)

    def _at_once(self) -> int:
        """Return how many tasks the cluster may have: nodes may have joined, or left."""
        self.workers = self._cores()
        return self.workers if self._most is not None else 2 * self.workers


def knock(address: str) -> None:
    """Raise OSError where nobody listens at an address: Ray itself would try for many minutes, and tell each try."""
    host, found, port = address.removeprefix("ray://").partition(":")
    if found:
        socket.create_connection((host, int(port)), timeout=_KNOCK_SECONDS).close()
