"""The robots that the kernel knows by name."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot._wire.services import Services
from virtualrobot.v1 import scene_pb2


@dataclass(frozen=True, slots=True)
class KnownModel:
    """A robot that the kernel knows by name: `client.load_robot("model://NAME")`.

    Attributes:
        name: the name.
        description: maker and kind, in one line.
        uri: its main file.
        package: the Python package that it comes with.
        installed: true where that package is installed on the kernel's machine.
    """

    name: str
    description: str
    uri: str
    package: str
    installed: bool


def known_models(services: Services) -> list[KnownModel]:
    """Return the models that a kernel knows, by name."""
    response = services.scene.ListModels(scene_pb2.ListModelsRequest())
    return [
        KnownModel(model.name, model.description, model.uri, model.package, model.installed)
        for model in response.models
    ]
