"""Limits are set by name, and each client's load is its own."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from virtualrobot_kernel.api.client_load import STOPPING, ClientLoad
from virtualrobot_kernel.api.limits import Limits, described
from virtualrobot_kernel.errors import KernelError, Reason


def test_limits_are_set_by_name() -> None:
    assert Limits.of(["nodes=50_000", "streams = 7", "asset_bytes=1,000"]) == Limits(
        50_000, streams=7, asset_bytes=1000
    )
    assert Limits.of([]) == Limits(**{name: default for name, default, _ in described()})


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("node=5", "there is no limit named 'node'; did you mean 'nodes'?"),
        ("", "there is no limit named ''; there are nodes, triangles, "),
        ("nodes", "from 1 to 100,000, not ''"),
        ("nodes=0", "not '0'"),
        ("nodes=-1", "not '-1'"),
        ("nodes=1e3", "not '1e3'"),
        ("nodes=100001", "from 1 to 100,000"),
        ("nodes=²", "not '²'"),
        (f"streams={'9' * 5000}", "the limit 'streams' is a whole number"),
    ],
)
def test_what_is_no_limit_is_refused(given: str, said: str) -> None:
    with pytest.raises(KernelError) as error:
        Limits.of([given])
    assert said in str(error.value)


def refused(call: Callable[[], object]) -> KernelError:
    with pytest.raises(KernelError) as error:
        call()
    assert error.value.reason is Reason.TOO_MANY_CALLS
    return error.value


def test_calls_are_counted_for_each_client_and_second_and_stopping_is_not() -> None:
    now = 10.2
    load = ClientLoad(Limits(calls_per_second=2), lambda: now)

    def call(client: str, method: str = "/virtualrobot.v1.SceneService/Apply") -> None:
        with load.of(client, method, False):
            pass

    for client in ("ada", "bob"):
        call(client)
        call(client)
        error = refused(lambda client=client: call(client))
        assert (error.metadata["limit_name"], error.metadata["limit"]) == ("calls_per_second", "2")
        for method in STOPPING:
            call(client, method)
    now = 11.0
    call("ada")


def test_streams_are_counted_while_they_are_open() -> None:
    load = ClientLoad(Limits(streams=2), lambda: 0.0)
    first, second = load.of("ada", "", True), load.of("ada", "", True)
    first.__enter__()
    second.__enter__()
    error = refused(load.of("ada", "", True).__enter__)
    assert (error.metadata["limit_name"], error.metadata["asked"]) == ("streams", "3")
    load.of("bob", "", True).__enter__()
    load.of("ada", "", False).__enter__()
    first.__exit__(None, None, None)
    load.of("ada", "", True).__enter__()
