"""Plugins and kinematics components through the client: listed, installed while the kernel runs, swapped, at fault."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, pose

from tests.api.client.conftest import IIWA
from tests.kernels import StartKernel
from tests.plugins.install import environment

PLUGIN = '''
from dataclasses import dataclass

from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.hookspecs import hookimpl

api_version = "1.0"


@dataclass(frozen=True)
class Settings:
    offset_meters: float = 0.0


class Shifted(ChainKinematics):
    """Solves as chain does, but puts the tip elsewhere."""

    def __init__(self, chain, settings):
        super().__init__(chain)
        self.offset = settings.offset_meters

    def forward(self, q):
        frames = super().forward(q).copy()
        frames[-1, 2, 3] += self.offset
        return frames

    def inverse(self, base_t_tip, options):
        if base_t_tip[2, 3] > 5.0:
            raise RuntimeError("nobody reaches so high")
        return super().inverse(base_t_tip, options)


@hookimpl
def virtualrobot_register_kinematics(register):
    # The first call loads compiled code, which a busy machine may need more than the usual second for.
    register("shifted", Shifted, Settings, deadline_seconds=30.0)
'''
BROKEN = 'raise ValueError("this plugin is broken on purpose")\n'


def install(site: Path, name: str, module: str) -> None:
    """Install a plugin as pip would: its module, and the entry point in its package's metadata."""
    (site / f"{name}_plugin.py").write_text(module)
    info = site / f"{name}-0.5.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.5\n")
    (info / "entry_points.txt").write_text(f"[virtualrobot.plugins]\n{name} = {name}_plugin\n")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that the kernel of these tests imports from."""
    return tmp_path_factory.mktemp("site")


@pytest.fixture(scope="module")
def client(start_kernel: StartKernel, site: Path) -> Iterator[Client]:
    """Return a client of a kernel in which plugins are installed while it runs."""
    kernel = start_kernel(environment=environment(site))
    with virtualrobot.connect(kernel.address) as client:
        assert {plugin.package for plugin in client.plugins} == {"virtualrobot"}
        install(site, "shifted", PLUGIN)
        install(site, "broken", BROKEN)
        client.plugins.reload()
        client.load_robot(IIWA, name="iiwa")
        yield client


@pytest.mark.long
def test_the_bundled_components_are_listed(client: Client) -> None:
    bundled = [plugin for plugin in client.plugins.list() if plugin.package == "virtualrobot"]
    assert {(plugin.state, plugin.reason, plugin.version) for plugin in bundled} == {
        ("loaded", "", client.info.version)
    }
    chain = next(one for one in client.plugins.components("kinematics") if one.name == "chain")
    assert (chain.isolation, chain.settings_schema) == ("in_process", {})
    assert all(component.description for component in client.plugins.components())
    assert all(component.endings for component in client.plugins.components("importer"))


@pytest.mark.long
def test_plugins_installed_since_are_found(client: Client) -> None:
    plugins = {plugin.name: plugin for plugin in client.plugins.reload()}
    shifted, broken = plugins["shifted"], plugins["broken"]
    assert (shifted.ok, shifted.version, shifted.package, shifted.api_version) == (True, "0.5", "shifted", "1.0")
    (component,) = shifted.components
    assert (component.name, component.kind, component.isolation) == ("shifted", "kinematics", "process")
    assert component.description == "Solves as chain does, but puts the tip elsewhere."
    assert component.settings_schema["properties"]["offset_meters"]["type"] == "number"
    assert (broken.ok, broken.components) == (False, ())
    assert "this plugin is broken on purpose" in broken.reason


def test_kinematics_are_swapped(client: Client) -> None:
    iiwa = client.robot("iiwa")
    goal = iiwa.solve_forward([0.3, 0.5, 0, -1.2, 0, 0.8, 0]).world_t_tcp
    check = iiwa.set_kinematics("shifted", {"offset_meters": 0.0})
    assert check.postures > 0
    # The tolerances of the self-check, and the order of central differences with steps of 1e-6.
    assert max(check.forward_position_error, check.inverse_position_error) < 1e-6
    assert max(check.forward_rotation_error, check.inverse_rotation_error) < 1e-6
    assert 0 < check.jacobian_error < 1e-5
    assert min(check.forward_time, check.inverse_time, check.jacobian_time) > 0
    assert (iiwa.kinematics, iiwa.kinematics_settings, iiwa.kinematics_fault) == ("shifted", {"offset_meters": 0}, "")
    np.testing.assert_allclose(iiwa.solve_forward(iiwa.solve_inverse(goal).best).world_t_tcp, goal, atol=1e-5)
    (use,) = next(one for one in client.plugins.components("kinematics") if one.name == "shifted").uses
    assert (use.robot, use.fault) == ("iiwa", "")
    assert use.calls > 3 * check.postures
    assert use.process_id not in (0, client.info.process_id)
    assert use.mean_call_time > 0

    iiwa.set_kinematics("chain")
    assert (iiwa.kinematics, iiwa.kinematics_settings) == ("chain", {})


def test_what_does_not_fit_is_refused_with_the_numbers(client: Client) -> None:
    iiwa = client.robot("iiwa")
    iiwa.set_kinematics("chain")
    with pytest.raises(virtualrobot.PluginFailedError, match=r"0\.25 m"):
        iiwa.set_kinematics("shifted", offset_meters=0.25)
    with pytest.raises(virtualrobot.VirtualRobotError, match="'offset'"):
        iiwa.set_kinematics("shifted", offset=0.25)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="'offset_meters'"):
        iiwa.set_kinematics("shifted", offset_meters=float("nan"))
    with pytest.raises(virtualrobot.VirtualRobotError, match="'shiffted'"):
        iiwa.set_kinematics("shiffted")
    assert iiwa.kinematics == "chain"


def test_a_fault_costs_one_call_and_is_told_until_another_component_is_chosen(client: Client) -> None:
    iiwa = client.robot("iiwa")
    iiwa.set_kinematics("shifted")
    with pytest.raises(virtualrobot.PluginFailedError, match="nobody reaches so high"):
        iiwa.solve_inverse(pose(z=10))
    assert "nobody reaches so high" in iiwa.kinematics_fault
    (use,) = next(one for one in client.plugins.components("kinematics") if one.name == "shifted").uses
    assert use.fault == iiwa.kinematics_fault
    assert iiwa.solve_inverse(iiwa.tcp).solved
    iiwa.set_kinematics("shifted")  # made anew
    assert iiwa.kinematics_fault == ""
    assert iiwa.solve_inverse(iiwa.tcp).solved
