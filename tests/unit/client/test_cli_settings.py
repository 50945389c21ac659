"""Settings on the command line, read as a component's schema has them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

import click
import msgspec
import pytest
from virtualrobot._wire import messages as wire
from virtualrobot.cli.settings import settings_from, settings_lines
from virtualrobot_sdk.settings import make_settings, schema


@dataclass(frozen=True)
class Group:
    label: str = ""
    depth: int = 1


@dataclass(frozen=True)
class Settings:
    name: str
    gain: Annotated[float, msgspec.Meta(gt=0, description="Step of each iteration.")] = 0.5
    method: Literal["newton", "secant"] = "newton"
    weights: list[float] | None = None
    arguments: dict[str, str] = field(default_factory=dict)
    group: Group = field(default_factory=Group)


# As it comes from a kernel.
SCHEMA = wire.settings_of(wire.settings_message(schema(Settings)))


def test_values_become_what_the_component_takes() -> None:
    """The SDK makes the component's own settings of them."""
    words = [
        *("name=7", "gain=0.25", "method=secant", "weights=[1, 2]", "arguments.dof=7", "arguments.empty="),
        *("group.label=true", "group.depth=3", "arguments.a=b=c"),
    ]
    assert make_settings(Settings, settings_from(words, SCHEMA)) == Settings(
        "7", 0.25, "secant", [1.0, 2.0], {"dof": "7", "empty": "", "a": "b=c"}, Group("true", 3)
    )


def test_without_a_schema_values_are_json_or_text() -> None:
    words = ["a=1", "b=x y", "c=true", "d=[1", "e.f=null"]
    assert settings_from(words, {}) == {"a": 1, "b": "x y", "c": True, "d": "[1", "e": {"f": None}}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["gain"], "write name=value"),
        (["=1"], "write name=value"),
        (["a..b=1"], "write name=value"),
        (["gain=1", "gain.x=2"], "gain was given a value before"),
    ],
)
def test_words_that_are_no_settings_are_refused(words: list[str], message: str) -> None:
    with pytest.raises(click.UsageError, match=message):
        settings_from(words, SCHEMA)


def test_each_setting_is_told_with_type_default_and_purpose() -> None:
    assert list(settings_lines(SCHEMA)) == [
        "arguments: object",
        "gain: number [0.5]  Step of each iteration.",
        "group: object",
        "method: newton or secant [newton]",
        "name: string",
        "weights: array or null [null]",
    ]
    assert list(settings_lines({})) == []
