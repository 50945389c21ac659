"""The table of the importers, what importing it costs, and what is said when a library is not there."""

import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any

import pytest
from virtualrobot_plugins.importers import virtualrobot_register_importers
from virtualrobot_plugins.importers.dxf.importer import DxfImporter
from virtualrobot_plugins.importers.ply import PlyImporter
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.step import StepImporter

from tests.unit.plugins.importers.reading import FILES, refusal


def test_each_ending_has_one_importer() -> None:
    table: dict[str, tuple[str, ...]] = {}

    def register(
        name: str,
        factory: Callable[..., Any],
        endings: Sequence[str],
        config_type: type | None = None,
        **options: object,
    ) -> None:
        made = factory() if config_type is None else factory(config_type())
        assert callable(made.translate) and factory.__doc__
        table[name] = tuple(endings)

    virtualrobot_register_importers(register)
    endings = [ending for some in table.values() for ending in some]
    assert sorted(endings) == [
        *(".3mf", ".dxf", ".off", ".ply", ".sdf", ".solid", ".step", ".stp", ".urdf", ".world", ".wrl", ".wrz"),
        ".xacro",
    ]


def test_importing_them_imports_no_library() -> None:
    heavy = ("trimesh", "ezdxf", "cascadio", "lxml", "PIL", "scipy", "networkx")
    code = f"import sys, virtualrobot_plugins.importers; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("importer", "data", "name", "module", "package", "extra"),
    [
        (DxfImporter(), FILES / "torus.dxf", "a.dxf", "ezdxf", "ezdxf", "dxf"),
        (PlyImporter(), FILES / "torus.ply", "a.ply", "trimesh", "trimesh", "kernel"),
        (SdfImporter(), FILES / "cell.wrl", "a.sdf", "lxml.etree", "lxml", "kernel"),
    ],
)
def test_a_library_that_is_not_there(
    importer: Any,  # noqa: ANN401  one of several
    data: Any,  # noqa: ANN401  a path
    name: str,
    module: str,
    package: str,
    extra: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    ending = "." + name.partition(".")[2]
    assert refusal(importer, data.read_bytes(), name).startswith(
        f"reading {ending} needs the package {package}: pip install 'virtualrobot[{extra}]'"
    )


def test_cascadio_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "virtualrobot_plugins.importers.step.find_spec", lambda name: None if name == "cascadio" else find_spec(name)
    )
    message = refusal(StepImporter(), (FILES / "bored_block.step").read_bytes(), "a.step")
    assert message == "reading .step needs the package cascadio: pip install 'virtualrobot[step]'"
