"""Offers of the kernel's own plugins are known without importing them, for as long as nothing has changed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from unittest import mock

import msgspec
import pytest
from virtualrobot_kernel.components import catalog, remembered
from virtualrobot_kernel.components.catalog import OWN_PACKAGE, Catalog
from virtualrobot_kernel.components.running import start
from virtualrobot_kernel.errors import KernelError
from virtualrobot_sdk.hookspecs import ENTRY_POINT_GROUP
from virtualrobot_sdk.loading import load
from virtualrobot_sdk.registration import ComponentKind, Isolation
from virtualrobot_sdk.worker.description import ComponentDescription, Description, describe

SECOND_START = """
import json, sys
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_sdk.registration import ComponentKind
catalog = Catalog()
before = [name for name in sys.modules if name.startswith("virtualrobot_plugins")]
chain = catalog.find(ComponentKind.KINEMATICS, "chain").register()
catalog.load()
after = [name for name in sys.modules if name.startswith("virtualrobot_plugins.")]
print(json.dumps({"before": before, "after": after, "chain": chain.description}))
"""


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have what is remembered in a folder of the test."""
    monkeypatch.setattr(remembered, "_path", lambda: tmp_path / "plugins.msgpack")


def own_points() -> list[EntryPoint]:
    points = entry_points(group=ENTRY_POINT_GROUP)
    return sorted((p for p in points if p.dist and p.dist.name == OWN_PACKAGE), key=lambda point: point.name)


def descriptions(points: list[EntryPoint]) -> dict[str, Description]:
    return {point.name: describe(*load(point)) for point in points}


def test_what_is_recalled_is_what_the_plugins_say() -> None:
    points = own_points()
    said = descriptions(points)
    assert remembered.recall(points) == {}
    remembered.remember(points, said)
    recalled = remembered.recall(points)
    # Of schemas, which are JSON, a tuple comes back as a list; models are the same to their types.
    assert msgspec.json.encode(recalled) == msgspec.json.encode(said)
    assert [repr(one.models) for one in recalled.values()] == [repr(one.models) for one in said.values()]


@pytest.mark.parametrize("data", [b"", b"\x00", b"\x93\xa1x\x90\x80", b"\xff" * 100])
def test_a_broken_file_counts_for_nothing(tmp_path: Path, data: bytes) -> None:
    points = own_points()
    (tmp_path / "plugins.msgpack").write_bytes(data)
    assert remembered.recall(points) == {}


def test_a_file_that_ends_early_counts_for_nothing(tmp_path: Path) -> None:
    points = own_points()[:1]
    remembered.remember(points, descriptions(points))
    whole = (tmp_path / "plugins.msgpack").read_bytes()
    for length in range(0, len(whole), max(1, len(whole) // 50)):
        (tmp_path / "plugins.msgpack").write_bytes(whole[:length])
        assert remembered.recall(points) == {}


def test_a_source_that_was_changed_has_all_asked_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "some_plugin"
    package.mkdir()
    source = package / "__init__.py"
    source.write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    points = [EntryPoint("some", "some_plugin", ENTRY_POINT_GROUP)]
    said = {"some": Description("1.0", ())}
    remembered.remember(points, said)
    assert remembered.recall(points) == said
    assert remembered.recall([EntryPoint("other", "some_plugin", ENTRY_POINT_GROUP)]) == {}
    os.utime(source, ns=(1, 1))
    assert remembered.recall(points) == {}


def test_deleted_code_has_all_imported_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    points, said = own_points()[:1], {"some": Description("1.0", ())}
    code = tmp_path / "search.nbi"
    code.write_bytes(b"")
    monkeypatch.setattr(remembered, "files_of_code", lambda *packages: [code])
    remembered.remember(points, said)
    assert remembered.recall(points) == said
    code.unlink()
    assert remembered.recall(points) == {}


def test_a_second_start_imports_no_plugin_before_one_is_used() -> None:
    # The cache of this checkout, which the first of these two fills where it has to.
    program = "from virtualrobot_kernel.components.catalog import Catalog; Catalog().remember()"
    subprocess.run([sys.executable, "-c", program], check=True)
    done = subprocess.run([sys.executable, "-c", SECOND_START], check=True, capture_output=True, text=True)
    told = json.loads(done.stdout)
    assert told["before"] == []
    assert {"virtualrobot_plugins.chain.component", "virtualrobot_plugins.sensor_models"} <= set(told["after"])
    assert told["chain"]


def test_the_catalogue_is_the_same_with_and_without_memory() -> None:
    def told(found: Catalog) -> list[object]:
        return [
            (plugin.name, plugin.api_version, plugin.models, msgspec.json.encode([o.about for o in plugin.offers]))
            for plugin in found.plugins
        ]

    first = Catalog()
    first.remember()
    assert remembered.recall(own_points())
    assert told(Catalog()) == told(first)


def test_a_plugin_that_cannot_be_loaded_any_more_fails_where_it_is_used(caplog: pytest.LogCaptureFixture) -> None:
    point = EntryPoint("gone", "no_such_package_of_plugins", ENTRY_POINT_GROUP)
    about = ComponentDescription(ComponentKind.KINEMATICS, "gone", "", Isolation.IN_PROCESS, 1.0, (), {})
    with mock.patch.object(remembered, "recall", return_value={"gone": Description("1.0", (about,))}):
        with mock.patch.object(catalog, "entry_points", return_value=[point]):
            with mock.patch.object(catalog, "_package", return_value=OWN_PACKAGE):
                found = Catalog()
    found.load()
    assert "the kinematics 'gone' can't be loaded: 'no_such_package_of_plugins' cannot be imported" in caplog.text
    with pytest.raises(KernelError, match="'gone' failed: 'no_such_package_of_plugins' cannot be imported"):
        start(found.find(ComponentKind.KINEMATICS, "gone"), {})
