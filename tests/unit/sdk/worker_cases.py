"""Components that do what components may not, for the tests of the worker process; each runs only inside of one."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from enum import Enum
from pathlib import Path

import numpy as np
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded, PluginError
from virtualrobot_sdk.kinematics import Floats, InverseResult, InverseStatus
from virtualrobot_sdk.rays import Primitive, RayScene

MIB = 1 << 20


class Own(Enum):
    """A type that only this module has."""

    VALUE = 1


class OddRefusal(ArgumentError):
    """A refusal of the author's own type."""


class Cases:
    """A component whose methods go wrong in every way."""

    greeting = "hello"

    def __init__(self, *arguments: object) -> None:
        """Keep the arguments."""
        self.arguments = arguments
        self.kept: list[bytes] = []

    # Well-behaved ones

    def add(self, a: float, b: float) -> float:
        return a + b

    def echo(self, value: object) -> object:
        return value

    def poses(self, q: Floats) -> Floats:
        return np.tile(np.eye(4), (8, 1, 1)) * q.sum()

    def solution(self) -> InverseResult:
        return InverseResult(InverseStatus.SOLVED, np.ones((2, 7)), ("elbow up", "elbow down"))

    def pid(self) -> int:
        return os.getpid()

    def environment(self, name: str) -> str | None:
        return os.environ.get(name)

    def modules(self) -> list[str]:
        return sorted(sys.modules)

    def count(self, scene: RayScene) -> int:
        return len(scene.shapes)

    def shapes(self, *scenes: RayScene) -> list[tuple[int, bool, str, float, Primitive | None]]:
        """Return of each shape which object it is, whether it can be written to, its key and what it holds."""
        every = [shape for scene in scenes for shape in scene.shapes]
        return [
            (
                id(shape),
                shape.vertices.flags.writeable or shape.triangles.flags.writeable,
                shape.key,
                float(shape.vertices[shape.triangles].sum()),
                shape.primitive,
            )
            for shape in every
        ]

    def fail_with(self, scene: RayScene) -> None:
        raise ValueError(f"{len(scene.shapes)} shapes are too many")

    # Refusals

    def refuse(self) -> None:
        raise ArgumentError("gain is -1; it must be positive", gain=-1)

    def refuse_oddly(self) -> None:
        raise OddRefusal("no", way="out")

    def need(self) -> None:
        raise FilesNeeded(["meshes/a.stl", "b.stl"])

    def plugin_error(self) -> None:
        raise PluginError("write it otherwise")

    # Faults

    def fail(self) -> None:
        self._deeper()

    def _deeper(self) -> None:
        raise ValueError("the matrix\nis singular")

    def fail_in_numpy(self) -> None:
        np.linalg.inv(np.zeros((2, 2)))

    def leave(self) -> None:
        sys.exit("licence missing")

    def work(self, core_seconds: float) -> None:
        """Compute for so long of a core's time."""
        ends = time.process_time() + core_seconds
        while time.process_time() < ends:
            pass

    def hang(self) -> None:
        time.sleep(1000)

    def hang_from(self, marker: str) -> None:
        """Say by a file that the call has begun."""
        Path(marker).touch()
        self.hang()

    def hang_in_native_code(self) -> None:
        # PyDLL keeps the GIL: no other thread of the process ever runs.
        ctypes.PyDLL(None).sleep(1000)

    def crash(self) -> None:
        ctypes.string_at(0)

    def die(self, code: int) -> None:
        print("these are my last words")
        os._exit(code)

    def kill_itself(self) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    def die_later(self) -> None:
        subprocess.Popen(["/bin/sh", "-c", f"sleep 0.1; kill -SEGV {os.getpid()}"])

    def unpicklable(self) -> Callable[[], int]:
        return lambda: 1

    def own_type(self) -> Own:
        return Own.VALUE

    def leak(self, mib: int) -> None:
        self.kept.append(b"x" * (mib * MIB))

    def leak_and_hang(self, mib: int) -> None:
        self.leak(mib)
        self.hang()

    # What gets at the pipes

    def talk(self) -> str:
        print("printed by Python")
        os.write(1, b"written to descriptor 1\n")
        ctypes.CDLL(None).puts(b"put by C")
        ctypes.CDLL(None).fflush(None)
        subprocess.run(["/bin/echo", "echoed by a process"], check=True)
        print("an error line", file=sys.stderr)
        return "done"

    def listen(self) -> bytes:
        return os.read(0, 100)

    def flood(self, lines: int) -> int:
        for i in range(lines):
            print(f"{i} " + "x" * 1000, file=sys.stderr)
        return lines

    def fork(self) -> int:
        """Fork a process that comes back into the loop of the worker, as `os.fork` without an end does."""
        if (pid := os.fork()) == 0:
            return 0
        os.waitpid(pid, 0)
        return 1

    def scribble(self, what: bytes) -> int:
        """Write into every pipe that is open beyond the standard ones, as a closed descriptor used again would."""
        for descriptor in range(3, 64):
            try:
                os.write(descriptor, what)
            except OSError:
                continue
        return 1

    def start_a_child(self, detached: bool = False) -> int:
        return subprocess.Popen(["/bin/sleep", "1000"], start_new_session=detached).pid


def make_wrongly() -> None:
    """Raise as a factory does."""
    raise RuntimeError("no such arm")


NOT_A_FACTORY = 3
