"""`virtualrobot topic heat`: what a floor feels comes to the weight of what stands on it, where that stands."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot import Client
from virtualrobot.cli import cli

from tests.kernels import KernelProcess, Stubs

SECONDS = 1.0
WEIGHT = 3.0 * 9.81


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    """Return a client of a world in which a box of 2 kg and a ball of 1 kg stand on a floor, in real time."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        scene = client.scene
        scene.add_object("floor", virtualrobot.box(4.0, 4.0, 0.1), pose=virtualrobot.pose(z=-0.05))
        scene.add_contact_sensor("skin", virtualrobot.contact_sensor("floor", rate=50.0), parent="floor")
        for name, figure, x, mass in (
            ("box", virtualrobot.box(0.2, 0.2, 0.2), 0.0, 2.0),
            ("ball", virtualrobot.sphere(0.1), 0.7, 1.0),
        ):
            scene.add_part(name, figure, pose=virtualrobot.pose(x, z=0.1), mass=mass, dynamic=True)
        client.physics.set("mujoco")
        client.clock.step(200)  # until both rest
        client.clock.set_realtime()
        yield client
        client.clock.set_stepped()


def heat(kernel: KernelProcess, *arguments: str) -> str:
    result = CliRunner().invoke(cli, ["topic", "heat", "--address", kernel.address, *arguments])
    assert result.exit_code == 0, result.output
    return result.output


def test_impulses_are_the_weight_over_the_time(client: Client, stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    said = heat(stepped_kernel, "skin", "--seconds", str(SECONDS), "--cell", "0.05", "--out", str(tmp_path / "map.svg"))
    total, most = re.search(r"([\d.]+) N s in all; most, ([\d.]+) N s", said).groups()  # type: ignore[union-attr]
    # Who is slow gets the latest reading, which may be later than the end.
    assert WEIGHT * SECONDS * 0.99 < float(total) < WEIGHT * SECONDS * 3.0
    assert float(most) == pytest.approx(float(total) / 3.0, rel=0.02), "the ball touches in one place"
    assert len(client.scene["heat of skin"].figures) == 1, "and stays drawn"
    assert client.sensors["skin"].status.state == "stopped", "as before"
    drawn = ElementTree.fromstring((tmp_path / "map.svg").read_text())
    assert len(drawn.findall("{http://www.w3.org/2000/svg}rect")) == 1 + 5, "four corners and a ball"


def test_without_physics_times_are_told(client: Client, stepped_kernel: KernelProcess) -> None:
    client.physics.set("none")
    said = heat(stepped_kernel, "skin", "--seconds", str(SECONDS))
    total, most = re.search(r"([\d.]+) s in all; most, ([\d.]+) s, at", said).groups()  # type: ignore[union-attr]
    assert float(most) == pytest.approx(float(total) / 5.0) and float(most) > 0.99 * SECONDS


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("floor",), "there is no contact sensor named 'floor'; there is skin"),
        (("skin", "--cell", "0"), "0.001<=x<=1.0"),
        (("skin", "--out", "map.png"), "--out takes a name that ends in .svg"),
    ],
)
def test_wrong_usage_is_told(
    client: Client, stepped_kernel: KernelProcess, arguments: tuple[str, ...], said: str
) -> None:
    result = CliRunner().invoke(cli, ["topic", "heat", "--address", stepped_kernel.address, *arguments])
    assert result.exit_code != 0 and (said in result.output or said in str(result.exception))
