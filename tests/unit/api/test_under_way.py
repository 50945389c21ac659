"""Calls that the page tells of: those of the contract, for as long as they take."""

from __future__ import annotations

import pytest
from google.protobuf import descriptor_pool
from virtualrobot_kernel.api import server as server  # all services are known then
from virtualrobot_kernel.api.interceptors import WORK
from virtualrobot_kernel.drawing.under_way import AFTER_SECONDS, UnderWay


def test_calls_that_may_take_long_are_those_of_the_contract() -> None:
    for path in WORK:
        service, method = path.removeprefix("/").split("/")
        assert method in descriptor_pool.Default().FindServiceByName(service).methods_by_name


def test_work_is_told_once_it_takes_long_each_kind_once_the_oldest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    work, now = UnderWay(), [100.0]
    monkeypatch.setattr("virtualrobot_kernel.drawing.under_way.time.monotonic", lambda: now[0])
    with work.doing("planning"), work.doing("loading a model"), work.doing("planning"):
        assert work.long() == ()
        now[0] += AFTER_SECONDS
        assert work.long() == ("planning", "loading a model")
    assert work.long() == ()
