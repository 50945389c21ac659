"""Each reason of the contract has an exception, and each exception is exported."""

from __future__ import annotations

import pytest
import virtualrobot
from virtualrobot import errors
from virtualrobot.v1 import errors_pb2


def test_every_reason_has_an_exception() -> None:
    reasons = {name.removeprefix("ERROR_REASON_") for name in errors_pb2.ErrorReason.keys()} - {"UNSPECIFIED"}
    assert set(errors.BY_REASON) == reasons


def test_every_exception_is_exported() -> None:
    classes = {name for name, kind in vars(errors).items() if isinstance(kind, type) and issubclass(kind, Exception)}
    assert classes <= set(dir(virtualrobot))
    for name in dir(virtualrobot):
        assert getattr(virtualrobot, name).__name__ == name


def test_an_exception_says_its_message_and_keeps_its_values() -> None:
    error = virtualrobot.UnknownNameError("there is no robot named 'x'", metadata={"valid": "arm"}, code="NOT_FOUND")
    assert str(error) == "there is no robot named 'x'"  # a KeyError would show it in quotes
    assert isinstance(error, KeyError)
    assert (error.reason, error.metadata, error.code) == ("UNKNOWN_NAME", {"valid": "arm"}, "NOT_FOUND")
    assert virtualrobot.LimitError("x", "OTHER").reason == "OTHER"


def test_an_unknown_attribute_is_told() -> None:
    with pytest.raises(AttributeError, match="no attribute 'conect'"):
        virtualrobot.conect  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue] that is the test
