"""Models by name, `model://NAME`: found among those that plugins make known."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches

from virtualrobot_sdk.models import Model

from virtualrobot_kernel.errors import MissingFileError, UnknownNameError

SCHEME = "model://"


def find(models: Mapping[str, Model], name: str) -> Model:
    """Return the model called `name`.

    Raises:
        UnknownNameError: when there is none; it names the nearest.
        MissingFileError: when there is, but its Python package is not installed; it says which one.
    """
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


def hint(models: Mapping[str, Model], uri: str) -> str:
    """Return a hint for who left `model://` away, with a space after it; empty for a URI like no model's name."""
    near = get_close_matches(uri.lower(), models, n=1, cutoff=0.8)
    return f"did you mean '{SCHEME}{near[0]}'? " if near else ""
