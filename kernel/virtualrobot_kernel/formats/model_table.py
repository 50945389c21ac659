"""Table of the robots that the kernel knows by name: model files in this package and in others on PyPI."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from importlib.resources import files as package_files

import yaml

from virtualrobot_kernel.errors import MissingFileError, UnknownNameError

SCHEME = "model://"

_OWN = "virtualrobot_kernel"


@dataclass(frozen=True, slots=True)
class KnownModel:
    """Robot that the kernel knows by name.

    Attributes:
        name: what it is asked for by, in small letters.
        description: maker, kind and axes, in one line.
        uri: its main file, `package://<Python package>/...`.
        package: the distribution on PyPI that the file comes with; empty for the kernel's own.
        license: of the model, as far as its package says.
        settings: for the importer, plain values.
    """

    name: str
    description: str
    uri: str
    package: str = ""
    license: str = ""
    settings: Mapping[str, object] = field(default_factory=dict)

    @property
    def module(self) -> str:
        """Return the Python package that the file lies in."""
        return self.uri.removeprefix("package://").partition("/")[0]

    @property
    def installed(self) -> bool:
        """Return whether the Python package is there; it is not imported."""
        return importlib.util.find_spec(self.module) is not None

    @property
    def how_to_install(self) -> str:
        """Return what makes the model available, in one sentence."""
        return f"the model {self.name!r} comes with the Python package {self.package}: pip install {self.package}"


@cache
def list_models() -> tuple[KnownModel, ...]:
    """Return the known models by name, whether installed or not."""
    text = (package_files(_OWN) / "models" / "models.yaml").read_text("utf-8")
    table = yaml.safe_load(text)
    packages = table["packages"]
    models = []
    for name, entry in table["models"].items():
        package = packages.get(entry["uri"].removeprefix("package://").partition("/")[0], {})
        models.append(
            KnownModel(
                name,
                entry["description"],
                entry["uri"],
                package.get("distribution", ""),
                entry.get("license", package.get("license", "")),
                entry.get("settings", {}),
            )
        )
    return tuple(sorted(models, key=lambda model: model.name))


def find(name: str) -> KnownModel:
    """Return the model called `name`.

    Raises:
        UnknownNameError: when the table has none; it names the nearest.
        MissingFileError: when it has, but its Python package is not installed; it says which one.
    """
    models = {model.name: model for model in list_models()}
    if name not in models:
        raise UnknownNameError("model", name, models)
    model = models[name]
    if not model.installed:
        raise MissingFileError(model.how_to_install, file=f"{SCHEME}{name}", package=model.package)
    return model


def named_by(uri: str) -> str:
    """Return the NAME of a URI `model://NAME`; empty when it is another one, such as a file in a package."""
    name = uri.removeprefix(SCHEME)
    return "" if name == uri or "/" in name else name


def hint(uri: str) -> str:
    """Return a hint for who left `model://` away, with a space after it; empty for a URI like no name of the table."""
    near = get_close_matches(uri.lower(), [model.name for model in list_models()], n=1, cutoff=0.8)
    return f"did you mean '{SCHEME}{near[0]}'? " if near else ""
