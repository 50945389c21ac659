"""What objects show at a prompt."""

from __future__ import annotations

from collections.abc import Iterator

import virtualrobot
from virtualrobot import Client, Robot

from tests.kernels import StartKernel

MOST_LINES = 5
MOST_LETTERS = 700


def handles(client: Client) -> Iterator[object]:
    """Yield what a client leads to by one or two dots."""
    yield client
    yield client.services
    for name, first in vars(client).items():
        if not name.startswith("_"):
            yield first
            yield from (second for name, second in getattr(first, "__dict__", {}).items() if not name.startswith("_"))


def check(one: object) -> None:
    """Check what an object of this library shows."""
    shown = repr(one)
    assert " object at 0x" not in shown, f"{type(one)} shows {shown}"
    assert 0 < len(shown.splitlines()) <= MOST_LINES, shown
    assert len(shown) <= MOST_LETTERS, shown


def test_everything_that_a_client_leads_to_shows_itself(client: Client, iiwa: Robot) -> None:
    every = [one for one in handles(client) if type(one).__module__.startswith("virtualrobot")]
    assert len({type(one) for one in every}) >= 13
    for one in every:
        check(one)


def test_a_line_says_what_is_worth_knowing(client: Client, iiwa: Robot) -> None:
    client.scene.add_range_sensor("lidar")
    client.signals.create("part", True)
    client.collisions.set("monitor", robots={"iiwa": "guard"}, look_ahead=1.0)
    client.view.joint_axes = ["iiwa"]
    client.clock.set_stepped()
    seconds = client.clock.simulation_time
    assert repr(client.clock) == f"<Clock: stepped, {seconds:.3f} s, goes on by step(), ticks of 4 ms>"
    assert repr(client.sensors) == "<Sensors: 'lidar' (range_sensor, stopped)>"
    assert repr(client.sensors["lidar"]) == "<Sensor 'lidar': stopped>"
    assert repr(client.signals) == "<Signals: 'part' = True>"
    assert repr(client.collisions) == "<Collisions: mode monitor, 'iiwa' guard, looks 1 s ahead>"
    assert repr(client.collisions.allowed) == f"<AllowedPairs: {len(client.collisions.allowed.list())} pairs may touch>"
    assert repr(client.view) == "<View: 0 browsers; joint axes of 1>"
    assert "RRTConnect" in repr(client.paths)
    with client.scene.batch() as batch:
        batch.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(x=3.0))
        batch.hide("box")
        assert repr(batch) == "<Batch of 2 changes: create_node, update_node>"


def test_a_handle_of_a_kernel_that_is_gone_shows_why(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    with virtualrobot.connect(kernel.address) as client:
        sensor, signals, clock = client.sensors, client.signals, client.clock
        kernel.process.kill()
        kernel.process.wait()
    for one in (client, sensor, signals, clock, client.view, client.collisions):
        check(one)
    assert repr(clock) == "<Clock: this client is closed: connect again>"
