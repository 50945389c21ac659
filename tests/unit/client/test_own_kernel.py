"""The end of a command by SIGTERM."""

from __future__ import annotations

import asyncio
import signal
import sys

import pytest
from virtualrobot.cli.own_kernel import interrupt_when_terminated


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM that a program hears")
def test_sigterm_lets_an_event_loop_end_its_tasks_and_counts_once() -> None:
    ends: list[str] = []

    async def work() -> None:
        try:
            signal.raise_signal(signal.SIGTERM)
            await asyncio.sleep(60.0)
        except asyncio.CancelledError:  # by the loop, not by what is raised amid it
            signal.raise_signal(signal.SIGTERM)
            await asyncio.sleep(0.0)
            ends.append("well")
            raise

    ours = [(number, signal.getsignal(number)) for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT)]
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        interrupt_when_terminated()
        with pytest.raises(KeyboardInterrupt):
            asyncio.run(work())
    finally:
        for number, handler in ours:
            signal.signal(number, handler)
    assert ends == ["well"]
