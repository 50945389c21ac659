"""Pool of threads in which pictures are taken without a browser, each with what it needs to see."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from virtualrobot_kernel.background import give_way
from virtualrobot_kernel.collision.clearances import Measure
from virtualrobot_kernel.drawing.renderer import Renderer
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Meshes

THREADS = 2
"""A large picture must not hold up what is under a pixel."""

Result = TypeVar("Result")


class RendererPool:
    """Owns the threads, which are started when first needed; any thread may ask."""

    def __init__(self, shapes: ShapeLibrary, looks: AppearanceLibrary, meshes: Meshes, clearances: Measure) -> None:
        """Make painters of these, as `Renderer` takes them."""
        self._made_of = shapes, looks, meshes, clearances
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="picture", initializer=give_way)
        self._own = threading.local()
        self._painters: list[Renderer] = []
        self._closing = threading.Event()

    def submit(self, work: Callable[[Renderer], Result], is_gone: Callable[[], bool] = lambda: False) -> Future[Result]:
        """Have `work` done by the next thread that is free; it raises KernelError where pictures can't be taken.

        A picture is given up soon after `is_gone` says that nobody waits for it any more.
        """
        return self._threads.submit(self._run, work, is_gone)

    def close(self) -> None:
        """Give up what is being worked on, and free everything."""
        self._closing.set()
        self._threads.shutdown(wait=True, cancel_futures=True)
        for painter in self._painters:
            painter.close()

    def _run(self, work: Callable[[Renderer], Result], is_gone: Callable[[], bool]) -> Result:
        def check() -> None:
            if self._closing.is_set() or is_gone():
                raise KernelError("nobody waits for this picture any more", reason=Reason.SHUTTING_DOWN)

        check()
        painter: Renderer | None = getattr(self._own, "painter", None)
        if painter is None:
            painter = self._own.painter = Renderer(*self._made_of)
            self._painters.append(painter)
        painter.check = check
        return work(painter)
