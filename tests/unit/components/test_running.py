"""What components raise and return, in this process: their faults stay theirs, and callers get plain copies."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_sdk.errors import ArgumentError, FaultKind, FilesNeeded, PluginError
from virtualrobot_sdk.registration import ComponentKind, Isolation, Registration
from virtualrobot_sdk.worker.description import describe


class Mute(Exception):
    """An error that has no words."""

    def __str__(self) -> str:
        """Raise."""
        raise RuntimeError("no words")


FAULTS = {
    "SystemExit": SystemExit("licence missing"),
    "KeyboardInterrupt": KeyboardInterrupt(),
    "StopIteration": StopIteration(),
    "its __str__ raises RuntimeError": Mute(),
    "write it otherwise": PluginError("write it otherwise"),
    r"asks for files \(a\.stl\)": FilesNeeded(["a.stl"]),
}


def offer(factory: Callable[..., object], kind: ComponentKind = ComponentKind.KINEMATICS) -> Offer:
    """Return what a plugin offers that is loaded into this process."""
    registration = Registration(kind, "tried", factory, isolation=Isolation.IN_PROCESS)
    (about,) = describe("1.0", [registration]).components
    return Offer(EntryPoint("tried", __name__, "virtualrobot.plugins"), about, lambda: registration)


def raising(error: BaseException) -> Callable[..., Any]:
    """Return a function that raises `error`."""

    def function(*_: object) -> None:
        raise error

    return function


def running(**methods: Callable[..., object]) -> ComponentHandle:
    """Return a component at work that has these methods."""
    return start(offer(lambda: type("Component", (), {n: staticmethod(m) for n, m in methods.items()})()), {})


@pytest.mark.parametrize("words", FAULTS)
def test_whatever_is_raised_is_a_fault_of_the_component(words: str) -> None:
    with pytest.raises(KernelError, match=words) as made:
        start(offer(raising(FAULTS[words])), {})
    one = running(work=raising(FAULTS[words]))
    for times in (1, 2):  # it is asked again: one fault says nothing about the next call
        with pytest.raises(KernelError, match=words) as called:
            one.call("work")
        assert (one.calls, one.fault) == (times, None)
        assert one.latest is not None
    for raised in (made, called):
        assert raised.value.reason is Reason.PLUGIN_FAILED
        assert raised.value.metadata["fault"] == "RAISED"


def test_a_method_that_is_not_there_is_a_fault() -> None:
    with pytest.raises(KernelError, match=r"AttributeError: .*'jacobian'") as raised:
        running().call("jacobian")
    assert raised.value.reason is Reason.PLUGIN_FAILED


def test_a_call_in_this_process_that_does_not_return_is_a_fault_until_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def work() -> bool:
        begun.set()
        return go_on.wait()

    one = running(work=work, other=bool)
    hanging = threading.Thread(target=one.call, args=("work",))
    hanging.start()
    begun.wait()
    assert (one.latest, one.call("other")) == (None, False)
    monkeypatch.setattr("virtualrobot_kernel.components.running.HUNG_SECONDS", 0.0)
    assert one.latest is not None and one.latest.kind is FaultKind.HUNG
    with pytest.raises(
        KernelError, match="'tried' failed: work has not returned for 0 s; in its own process"
    ) as raised:
        one.call("other")
    assert raised.value.metadata["fault"] == "HUNG"
    go_on.set()
    hanging.join()
    assert (one.call("other"), one.fault) == (False, None)


def test_a_refusal_may_name_its_metadata_as_it_likes() -> None:
    refused = ArgumentError("too far", reason="reach", kind="pose")
    for ask in (lambda: start(offer(raising(refused)), {}), lambda: running(work=raising(refused)).call("work")):
        with pytest.raises(KernelError, match="too far") as raised:
            ask()
        assert raised.value.reason is Reason.INVALID_ARGUMENT
        assert raised.value.metadata == {"reason": "reach", "kind": "pose"}


def test_an_importer_may_ask_for_files() -> None:
    importer = type("Importer", (), {"translate": raising(FilesNeeded(["a.stl"]))})
    one = start(offer(importer, ComponentKind.IMPORTER), {})
    with pytest.raises(FilesNeeded):
        one.call("translate")
    assert one.fault is None


def test_a_fault_names_the_line_of_the_author() -> None:
    def work() -> None:
        np.linalg.inv(np.zeros((2, 2)))

    line = sys._getframe().f_lineno - 2
    with pytest.raises(KernelError, match=rf"LinAlgError: Singular matrix \(test_running\.py:{line} in work\)"):
        running(work=work).call("work")
