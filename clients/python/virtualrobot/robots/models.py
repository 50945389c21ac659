"""Models of robots and grippers that the kernel knows by name."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot._wire.services import Services
from virtualrobot.v1 import scene_pb2


@dataclass(frozen=True, slots=True, repr=False)
class KnownModel:
    """Model that the kernel knows by name: `client.load_robot("model://NAME")`.

    Attributes:
        name: the name.
        description: maker and type, in one line.
        uri: its main file; empty where a plugin has the model itself.
        package: distribution that brings the file, for `pip install`; empty where a plugin has it.
        installed: true where that package is installed on the kernel's machine.
        maker: of the real one; empty where the model stands for no product.
        kind: `arm`, `scara`, `palletizer`, `gripper`, `mobile`, `mobile_manipulator`, `legged` or `axis`.
        axes: number of joints of the arm; of what has no arm, of joints that can be moved by themselves.
        payload: greatest load at the flange by the data sheet (kg); None where none is told.
        reach: reach as the data sheet tells it (m); None where none is told.
        license: of the model's file.
        source: document that the numbers are from.
    """

    name: str
    description: str
    uri: str
    package: str
    installed: bool
    maker: str
    kind: str
    axes: int
    payload: float | None
    reach: float | None
    license: str
    source: str

    def __repr__(self) -> str:
        """Return a line for people."""
        numbers = f"{self.axes} axes" if self.axes else self.kind
        payload = f", {self.payload:g} kg" if self.payload else ""
        reach = f", {self.reach:g} m" if self.reach else ""
        missing = "" if self.installed or not self.package else f"; pip install {self.package}"
        return f"<KnownModel {self.name!r}: {self.description}, {numbers}{payload}{reach}{missing}>"


def known_models(services: Services, search: str | None = None, maker: str | None = None) -> list[KnownModel]:
    """Return the models that a kernel knows, by name: those with all words of `search` and of this `maker`."""
    response = services.scene.ListModels(scene_pb2.ListModelsRequest())
    models = [
        KnownModel(
            one.name,
            one.description,
            one.uri,
            one.package,
            one.installed,
            one.maker,
            one.kind,
            one.axes,
            one.payload_kilograms or None,
            one.reach_meters or None,
            one.license,
            one.source,
        )
        for one in response.models
    ]
    return [model for model in models if _fits(model, (search or "").lower().split(), (maker or "").lower())]


def _fits(model: KnownModel, words: list[str], maker: str) -> bool:
    text = f"{model.name} {model.description} {model.maker} {model.kind}".lower()
    return maker in model.maker.lower() and all(word in text for word in words)
