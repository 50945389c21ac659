"""Hunt for a failure by chance: the tests that draw random numbers run again and again, each time with a fresh seed."""

from __future__ import annotations

import os
import re
import secrets
import signal
import subprocess
import sys
import threading
import time

import click


@click.command()
@click.option("--minutes", type=float, required=True, help="How long, as long as nothing fails.")
@click.option("--seed", type=int, help="That of the first run; the next ones count on.")
@click.argument("room")
def main(minutes: float, seed: int | None, room: str) -> None:
    """Hunt in a file or folder of tests."""
    end = time.monotonic() + 60.0 * minutes
    seed = secrets.randbits(32) if seed is None else seed
    runs = 0
    while (left := end - time.monotonic()) > 0:
        print(f"seed {seed} ...", flush=True)
        failed = _failed(room, seed, left)
        if failed:
            print("Repeat with:")
            for test in failed:
                print(f"VIRTUALROBOT_TEST_SEED={seed} {sys.executable} -m pytest -m '' '{test}'")
            raise SystemExit(1)
        seed, runs = seed + 1, runs + 1
    print(f"{runs} runs, the last one up to the end of the time; nothing failed")


def _failed(room: str, seed: int, seconds: float) -> list[str]:
    """Return the tests of a room that fail with a seed, as far as the time goes."""
    chosen = "(seeded or hunted) and not long"
    command = [sys.executable, "-m", "pytest", "-q", "-m", chosen, "-n", "2", "--dist", "loadfile"]
    environment = {**os.environ, "VIRTUALROBOT_TEST_SEED": str(seed), "VIRTUALROBOT_HUNT_SECONDS": str(0.9 * seconds)}
    with subprocess.Popen([*command, "--maxfail=3", room], stdout=subprocess.PIPE, text=True, env=environment) as run:
        assert run.stdout is not None
        over = threading.Timer(seconds, run.send_signal, [signal.SIGINT])
        over.start()
        said = run.stdout.read()
        over.cancel()
    failed = re.findall(r"^(?:FAILED|ERROR) (\S+::.*?)(?: - .*)?$", said, re.MULTILINE)
    if failed or run.returncode not in (0, 2):  # 2: interrupted, when the time was over
        print(said)
    if not failed and run.returncode not in (0, 2):
        raise SystemExit(run.returncode)
    return failed


if __name__ == "__main__":
    main()
