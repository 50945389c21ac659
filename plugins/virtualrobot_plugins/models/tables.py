"""Tables of models, a YAML file for each maker or package: adding a model is adding an entry.

    defaults: {maker: ABB, license: MIT (VirtualRobot), source: product specification}
    color: [0.9, 0.5, 0.1]
    models:
      irb120:
        description: ABB IRB 120-3/0.6
        arm: {joints: [...], flange: [...], home: [...]}

An entry has the fields of `Model`, those of the table's `defaults` unless it says otherwise, and where there is no file
`arm` (see `arms.Arm`), `jaws` or `cups` (see `grippers`), or `walker` (see `walkers.Walker`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.resources import files
from typing import Any

import yaml
from virtualrobot_sdk.errors import ArgumentError, PluginError
from virtualrobot_sdk.models import Model
from virtualrobot_sdk.settings import make_settings

from virtualrobot_plugins.models.arms import Arm, arm_scene
from virtualrobot_plugins.models.grippers import Cups, Jaws, cups_scene, jaws_scene
from virtualrobot_plugins.models.walkers import Walker, walker_scene

_SCENES: dict[str, tuple[type[Any], Callable[..., str]]] = {
    "arm": (Arm, arm_scene),
    "jaws": (Jaws, jaws_scene),
    "cups": (Cups, cups_scene),
    "walker": (Walker, walker_scene),
}
"""Geometries of models without a file, by the key of an entry."""
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_tables() -> Iterator[Model]:
    """Yield the models of all tables; raise PluginError, naming table and model, where one is not as it must be."""
    for file in sorted((files("virtualrobot_plugins.models") / "tables").iterdir(), key=lambda file: file.name):
        table = yaml.load(file.read_text("utf-8"), _LOADER)
        for name, entry in table["models"].items():
            try:
                yield read_entry(name, {**table.get("defaults", {}), **entry}, table.get("color", (0.8, 0.8, 0.82)))
            except ArgumentError as error:
                raise PluginError(f"{file.name}: {name}: {error}") from error


def read_entry(name: str, entry: dict, color: tuple[float, float, float]) -> Model:
    """Return the model of an entry; raise ArgumentError for a field that is unknown, missing or wrong.

    Args:
        name: of the model.
        entry: fields of `Model` and of the arm, as the table has them.
        color: red, green and blue of bodies of our own, 0 to 1.
    """
    fields = {"name": name, **entry}
    for key, (geometry, scene) in _SCENES.items():
        if key in fields:
            made: Any = make_settings(geometry, fields.pop(key))
            fields |= {"scene": scene(name, made, color), "axes": made.axes}
    model = make_settings(Model, fields)
    assert model is not None
    return model
