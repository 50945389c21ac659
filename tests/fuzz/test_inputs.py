"""Bytes of strangers: files and calls, damaged at random, and what has broken something once."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

import grpc
import pytest

from tests.fuzz.calls import Caller, Changer, shown
from tests.fuzz.mutation import mutated
from tests.fuzz.readers import READERS, refused, start_scene
from tests.kernels import KernelProcess, emptied
from tests.tiers import Draws

FOUND = Path(__file__).parent / "found"
"""Inputs that have broken something, by the name of their reader."""


@pytest.mark.parametrize("path", sorted(FOUND.glob("*/*")))
def test_what_has_broken_a_reader_is_refused(path: Path) -> None:
    assert refused(READERS[path.parent.name].read, path.read_bytes())


@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_refused_in_words(name: str, seed: int, draws: Draws) -> None:
    rng, reader = random.Random(seed), READERS[name]
    seeds = reader.seeds()
    for _ in range(max(1, draws(100) // reader.cost)):
        data = mutated(rng.choice(seeds), rng)
        try:
            refused(reader.read, data)
        except Exception:
            print(data)
            raise


def test_calls_at_random_meet_no_fault(stepped_kernel: KernelProcess, seed: int, draws: Draws, tmp_path: Path) -> None:
    rng = random.Random(seed)
    with emptied(stepped_kernel) as stubs:
        caller = Caller(stubs, start_scene(tmp_path), stepped_kernel.lines)
        changer = Changer(caller.start)
        inputs, codes = list(changer.seeds()), set[grpc.StatusCode]()
        for _ in range(draws(300)):
            data = changer.made(rng) if rng.random() < 0.2 else changer.changed(rng.choice(inputs), rng)
            try:
                codes.update(caller.answer(data))
            except Exception:
                print(shown(data), file=sys.stderr)
                raise
            inputs.append(data)
    assert {grpc.StatusCode.OK, grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.NOT_FOUND} <= codes


@pytest.mark.hunted
@pytest.mark.timeout(0)
@pytest.mark.parametrize("target", ["calls", *READERS])
def test_no_bytes_break_anything(target: str, hunt_seconds: float, tmp_path: Path) -> None:
    """Have atheris look for code that no input has reached yet: half of the time for the contract, half for files."""
    pytest.importorskip("atheris", reason="it has wheels for Linux on x86_64 alone")
    # 0 would be without end.
    seconds = max(1, int(hunt_seconds / 2 if target == "calls" else hunt_seconds / 2 / len(READERS)))
    options = [
        f"-max_total_time={seconds}",
        f"-artifact_prefix={tmp_path}/found-",
        "-timeout=120",
        "-rss_limit_mb=4096",
    ]
    (tmp_path / "corpus").mkdir()
    command = [sys.executable, "-m", "tests.fuzz", target, str(tmp_path / "corpus"), *options]
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    assert run.returncode == 0, f"{run.stdout[-6000:]}\nits input: {[str(one) for one in tmp_path.glob('found-*')]}"
    print(f"{target}: {run.stdout.splitlines()[-1]}")
