"""Tables of models: what is wrong in one is told with the table and the model."""

from __future__ import annotations

import re

import pytest
from virtualrobot_plugins.models.tables import read_entry, read_tables
from virtualrobot_sdk.errors import ArgumentError

JOINT = [0, 0, 100, "z", -90, 90, 180]


def arm(**fields: object) -> dict:
    return {
        "description": "x",
        "arm": {"joints": [JOINT, [0, 0, 100, "-x", -90, 90, 180]], "flange": [0, 0, 300, "z"]} | fields,
    }


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({}, "description"),
        ({"description": "x", "payload": 3}, "there is no setting 'payload'"),
        ({"description": "x", "kind": "robot"}, "it must be one of 'arm', 'axis'"),
        ({"description": "x", "reach_meters": -1.0}, "reach_meters"),
        (arm(flange=[0, 0, 300, "up"]), "must be one of '-x', '-y'"),
        (arm(joints=[JOINT[:-1]]), "joints"),
        (arm(joints=[]), "joints"),
        ({"description": "x", "cups": {"plate": [60, 60, 0], "cups": [[0, 0, 20]], "height": 30, "mass": 1}}, "plate"),
        ({"description": "x", "walker": {"body": [200, 90, 40], "mass": 1, "hips": {}, "rows": [], "foot": 8}}, "rows"),
    ],
)
def test_what_is_wrong_in_an_entry_is_named(entry: dict, said: str) -> None:
    with pytest.raises(ArgumentError, match=re.escape(said)):
        read_entry("mine", entry, (0.5, 0.5, 0.5))


def test_an_arm_needs_no_more_than_its_axes() -> None:
    model = read_entry("mine", arm(), (0.5, 0.5, 0.5))
    assert (model.name, model.axes, model.kind, model.uri) == ("mine", 2, "arm", "")


def test_every_name_is_there_once_and_tells_where_it_is_from() -> None:
    models = list(read_tables())
    assert len({model.name for model in models}) == len(models) > 85
    assert all(model.license and (model.axes or model.kind == "gripper") for model in models)
    assert all(bool(model.package) == (not model.scene and "virtualrobot_plugins" not in model.uri) for model in models)
