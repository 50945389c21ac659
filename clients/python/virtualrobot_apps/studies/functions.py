"""Functions of studies, by name: beside the study file or among what is installed, with a digest of their source."""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import platform
import sys
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

from virtualrobot._wire.names import nearest
from virtualrobot.errors import InvalidArgumentError, UnknownNameError

_PACKAGES = ("virtualrobot", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Return the versions that results may depend on, by package; without those that aren't installed."""
    found = {"python": ".".join(platform.python_version_tuple()[:2])}
    for name in _PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def digest(reference: str, folder: Path) -> str:
    """Return the SHA-256 (hexadecimal) of what a function's module says, and of those of the folder that it imports.

    Comments and the way it is set don't count. Of what is installed the module alone counts.

    Raises:
        UnknownNameError: when there is no such module.
        InvalidArgumentError: when it is not Python.
    """
    parts = [f"{file.stem}\n{ast.dump(tree)}" for file, tree in _sources(reference.partition(":")[0], folder)]
    return hashlib.sha256("\n".join(sorted(parts)).encode()).hexdigest()


def load(reference: str, folder: Path) -> Callable[..., Any]:
    """Return the function `module:function`; a module of the folder is read anew.

    Raises:
        UnknownNameError: when there is no such module or function.
        InvalidArgumentError: when the module fails as it is imported, or the name is no function's.
    """
    module_name, _, name = reference.partition(":")
    file = _file(module_name, folder)
    if file is not None and module_name.partition(".")[0] in sys.stdlib_module_names:
        raise InvalidArgumentError(f"{file} is called as a module of Python's own: give it another name")
    try:
        module = importlib.import_module(module_name) if file is None else _fresh(module_name, file, folder)
    except Exception as error:
        raise InvalidArgumentError(f"{module_name} fails when imported: {type(error).__name__}: {error}") from error
    function = getattr(module, name, None)
    if function is None:
        there = [one for one, value in vars(module).items() if callable(value) and not one.startswith("_")]
        raise UnknownNameError(f"{module_name} has no function {name!r}; {nearest(name, there)}")
    if not callable(function):
        raise InvalidArgumentError(f"{reference} is no function but {function!r}")
    return function


def _file(module: str, folder: Path) -> Path | None:
    """Return the file of a module of the folder; None for one that is installed."""
    file = folder.joinpath(*module.split(".")).with_suffix(".py")
    return file if file.is_file() else None


def _sources(module: str, folder: Path) -> Iterator[tuple[Path, ast.Module]]:
    first = _file(module, folder)
    if first is None:
        yield _parsed(_installed(module, folder))
        return
    waiting, seen = [first], {first}
    while waiting:
        file, tree = _parsed(waiting.pop())
        yield file, tree
        for name in _imported(tree):
            other = _file(name, folder)
            if other is not None and other not in seen:
                seen.add(other)
                waiting.append(other)


def _installed(module: str, folder: Path) -> Path:
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        spec = None
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        raise UnknownNameError(f"there is no module {module!r}, neither in {folder} nor among those installed")
    return Path(spec.origin)


def _parsed(file: Path) -> tuple[Path, ast.Module]:
    try:
        return file, ast.parse(file.read_bytes(), str(file))
    except (SyntaxError, ValueError) as error:
        raise InvalidArgumentError(f"{file} is not Python: {error}") from error


def _imported(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _fresh(name: str, file: Path, folder: Path) -> ModuleType:
    """Return a module made of what its file says now, whatever was imported before."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    for other, _ in _sources(name, folder):
        sys.modules.pop(".".join(other.relative_to(folder).with_suffix("").parts), None)
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    # Not by its loader: compiled files are told apart by the second.
    exec(compile(file.read_bytes(), str(file), "exec"), module.__dict__)
    return module
