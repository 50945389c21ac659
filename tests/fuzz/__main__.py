"""Fuzzing by atheris, led by coverage: `python -m tests.fuzz urdf FOLDER -max_total_time=60`; libFuzzer takes the rest.

The target is a reader of `tests/fuzz/readers.py`, or `calls` for the contract. The folder holds the corpus; what to
begin with is written there first. An input that breaks something is written where `-artifact_prefix` says.
"""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
import random
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import atheris
import virtualrobot_kernel.numeric
import virtualrobot_sdk.compiled
import virtualrobot_sdk.embree

# What numba compiles is imported before: it knows nothing of the instructions that count.
for package in (virtualrobot_kernel.numeric, virtualrobot_sdk.compiled, virtualrobot_sdk.embree):
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{package.__name__}.{module.name}")

with atheris.instrument_imports(  # pyright: ignore[reportAttributeAccessIssue] its stub lacks it
    include=["virtualrobot_kernel", "virtualrobot_sdk", "virtualrobot_plugins.importers", "trimesh", "collada"]
):
    from tests.fuzz import calls
    from tests.fuzz.mutation import mutated
    from tests.fuzz.readers import READERS, refused

Changed = Callable[[bytes, random.Random], bytes]


def main() -> None:
    """Fuzz until the time is over or something breaks."""
    name, corpus, *options = sys.argv[1:]
    if name == "calls":
        with calls.caller_inside() as caller:
            _fuzz(corpus, options, *_calls(caller))
    else:
        _fuzz(corpus, options, *_reader(name))


def _fuzz(
    corpus: str, options: list[str], read: Callable[[bytes], None], seeds: Iterable[bytes], changed: Changed
) -> None:
    for seed in seeds:
        Path(corpus, hashlib.sha1(seed).hexdigest()).write_bytes(seed)

    def change(data: bytes, most: int, seed: int) -> bytes:
        rng = random.Random(seed)
        made = changed(data, rng) if rng.random() < 0.8 else atheris.Mutate(data, most)
        return made if len(made) <= most else data

    atheris.Setup([sys.argv[0], corpus, *options], read, custom_mutator=change)
    atheris.Fuzz()


def _reader(name: str) -> tuple[Callable[[bytes], None], Iterable[bytes], Changed]:
    reader = READERS[name]

    def read(data: bytes) -> None:
        refused(reader.read, data)

    return read, reader.seeds(), mutated


def _calls(caller: calls.Caller) -> tuple[Callable[[bytes], None], Iterable[bytes], Changed]:
    def answer(data: bytes) -> None:
        try:
            caller.answer(data)
        except Exception:
            print(calls.shown(data), file=sys.stderr)
            raise

    changer = calls.Changer(caller.start)
    return answer, changer.seeds(), changer.changed


if __name__ == "__main__":
    main()
