"""Settings of components: the schema, what is taken and what is refused in which words."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Any, Literal

import msgspec
import pytest
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.settings import make_settings, schema


class Method(Enum):
    NEWTON = "newton"
    SECANT = "secant"


@dataclass(frozen=True)
class Inner:
    """A part with a group of any names."""

    named: dict[str, str] = field(default_factory=dict)
    size: float = 1.0


@dataclass(frozen=True)
class Grouped:
    """Settings with a group of any names, and a part that has one, too."""

    named: dict[str, str] = field(default_factory=dict)
    inner: Inner = field(default_factory=Inner)


@dataclass(frozen=True)
class Joint:
    """One joint."""

    name: str
    offset: float = 0.0


@dataclass(frozen=True)
class Settings:
    """Everything that settings may have."""

    gain: Annotated[float, msgspec.Meta(gt=0, description="Step of each iteration.")] = 0.5
    steps: Annotated[int, msgspec.Meta(ge=1, le=100)] = 10
    names: tuple[str, ...] = ()
    pair: tuple[float, float] = (0.0, 1.0)
    method: Method = Method.NEWTON
    sign: Literal[-1, 1] = 1
    base: Joint | None = None
    joints: list[Joint] = field(default_factory=list)
    offsets: dict[str, float] = field(default_factory=dict)
    limit: float | str = "none"
    strict: bool = False

    def __post_init__(self) -> None:
        """Refuse what no type says."""
        if self.steps == 13:
            raise ValueError("steps must not be 13 where somebody is superstitious")


@dataclass(frozen=True)
class Tree:
    """Settings that hold their own kind."""

    size: int = 1
    children: tuple[Tree, ...] = ()


@dataclass(frozen=True)
class Required:
    """Settings without which there is no component."""

    table: list[list[float]]


def refused(given: dict[str, Any], config_type: type = Settings) -> ArgumentError:
    with pytest.raises(ArgumentError) as raised:
        make_settings(config_type, given)
    return raised.value


def test_a_component_without_settings_has_an_empty_schema_and_takes_none() -> None:
    assert schema(None) == {}
    assert make_settings(None, {}) is None
    with pytest.raises(ArgumentError, match="has no settings; 'gain' was given"):
        make_settings(None, {"gain": 1.0})


def test_the_schema_says_types_limits_defaults_and_descriptions_in_the_order_of_the_fields() -> None:
    found = schema(Settings)
    assert list(found["properties"]) == list(Settings.__dataclass_fields__)
    assert found["properties"]["gain"] == {
        "type": "number",
        "exclusiveMinimum": 0,
        "default": 0.5,
        "description": "Step of each iteration.",
    }
    assert found["additionalProperties"] is False
    assert found["$defs"]["Method"]["enum"] == ["newton", "secant"]
    assert found["$defs"]["Joint"]["required"] == ["name"]
    assert found["$defs"]["Joint"]["additionalProperties"] is False
    assert json.dumps(found) == json.dumps(schema(Settings))
    assert schema(Required)["required"] == ["table"]


def test_without_anything_given_the_defaults_count() -> None:
    assert make_settings(Settings, {}) == Settings()


def test_numbers_of_a_protobuf_struct_are_all_floats_and_still_whole_numbers() -> None:
    made = make_settings(
        Settings,
        {
            "gain": 2.0,
            "steps": 3.0,
            "names": ["a"],
            "pair": [1.0, 2.5],
            "method": "secant",
            "sign": -1.0,
            "base": {"name": "foot"},
            "joints": [{"name": "a", "offset": 1.0}],
            "offsets": {"a": 0.25},
            "limit": 3.5,
            "strict": True,
        },
    )
    assert made == Settings(
        2.0, 3, ("a",), (1.0, 2.5), Method.SECANT, -1, Joint("foot"), [Joint("a", 1.0)], {"a": 0.25}, 3.5, True
    )
    assert made is not None and isinstance(made.steps, int) and isinstance(made.gain, float)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"gain": -1.0}, "setting 'gain' is -1.0; it must be a number > 0.0"),
        ({"gain": "fast"}, "setting 'gain' is 'fast'; it must be a number"),
        ({"gain": True}, "setting 'gain' is True; it must be a number"),
        ({"gain": None}, "setting 'gain' is None; it must be a number"),
        ({"gain": float("nan")}, "setting 'gain' is nan; it must be finite"),
        ({"offsets": {"a": float("inf")}}, "setting 'offsets[...]' is inf; it must be finite"),
        ({"steps": 3.5}, "setting 'steps' is 3.5; it must be a whole number"),
        ({"steps": 101.0}, "setting 'steps' is 101.0; it must be a whole number <= 100"),
        ({"steps": 1e300}, "setting 'steps' is 1e+300; it must be a whole number"),
        ({"strict": 1.0}, "setting 'strict' is 1.0; it must be true or false"),
        ({"names": "a"}, "setting 'names' is 'a'; it must be a list"),
        ({"pair": [1.0]}, "setting 'pair' is [1.0]; it must be a list of length 2"),
        ({"method": "guess"}, "setting 'method' is 'guess'; it must be one of 'newton', 'secant'"),
        ({"sign": 0.0}, "setting 'sign' is 0.0; it must be one of -1, 1"),
        ({"base": 3.0}, "setting 'base' is 3.0; it must be a group of settings or nothing"),
        ({"base": {}}, "setting 'base.name' is missing"),
        ({"joints": [{"name": "a"}, {"name": 1.0}]}, "setting 'joints[1].name' is 1.0; it must be text"),
        ({"limit": []}, "setting 'limit' is []; it must be a number or text"),
        ({"steps": 13.0}, "steps must not be 13 where somebody is superstitious"),
        ({"gian": 1.0}, "there is no setting 'gian'; did you mean 'gain'?"),
        ({"joints": [{"name": "a", "ofset": 1.0}]}, "there is no setting 'joints[0].ofset'; did you mean 'offset'?"),
        ({"base": {"xyz": 1.0}}, "there is no setting 'base.xyz'; there is name, offset"),
    ],
)
def test_what_is_wrong_is_named_with_what_would_be_right(given: dict[str, Any], said: str) -> None:
    error = refused(given)
    assert str(error) == said
    assert error.metadata.get("setting") == (said.split("'")[1] if said[0] in "st" and "'" in said else "")


def test_a_group_of_any_names_is_meant_by_what_stands_beside_it_alone() -> None:
    """As the arguments of a xacro file are; in a document, such as a vehicle's, a name too many is no source."""
    assert str(refused({"colour": "red"}, Grouped)) == "there is no setting 'colour'; did you mean 'named.colour'?"
    assert str(refused({"inner": {"named": {}, "colour": 1}}, Grouped)) == (
        "there is no setting 'inner.colour'; there is named, size"
    )


def test_a_long_value_is_not_repeated_whole() -> None:
    assert len(str(refused({"gain": "x" * 5000}))) < 200


def test_what_must_be_given_is_asked_for() -> None:
    assert str(refused({}, Required)) == "setting 'table' is missing"
    assert str(refused({"table": [[1.0, "a"]]}, Required)) == "setting 'table[0][1]' is 'a'; it must be a number"


def test_settings_may_hold_their_own_kind() -> None:
    assert schema(Tree)["$defs"]["Tree"]["properties"]["children"]["items"] == {"$ref": "#/$defs/Tree"}
    given = {"size": 2.0, "children": [{"size": 3.0}]}
    assert make_settings(Tree, given) == Tree(2, (Tree(3),))
    assert str(refused({"children": [{"sise": 1.0}]}, Tree)) == (
        "there is no setting 'children[0].sise'; did you mean 'size'?"
    )
