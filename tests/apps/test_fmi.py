"""FMUs: controllers of FMI 2.0 and 3.0 in lockstep, and a cell that FMPy's master steps."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from pythonfmu import FmuBuilder as Builder2
from pythonfmu3 import FmuBuilder as Builder3
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError, WrongStateError
from virtualrobot_apps.fmi.cell import INPUT, plan_cell
from virtualrobot_apps.fmi.export import export_cell
from virtualrobot_apps.fmi.wire import FmuWire
from virtualrobot_apps.lockstep.exchange import Lockstep
from virtualrobot_apps.lockstep.wire import ProgramWire

from tests.kernels import KernelProcess

pytestmark = pytest.mark.long

DOCS = Path(__file__).resolve().parents[2] / "docs"
GUARD = 60.0
PERIOD = 0.048
"""Twelve ticks, so that the time of the state is that of the FMU's steps."""


def block(page: str) -> str:
    """Return the first program in Python that a page has."""
    return re.findall(r"```python\n(.*?)```", (DOCS / page).read_text("utf-8"), re.DOTALL)[0]


def as_fmi2(text: str) -> str:
    """Return the controller of the page for FMI 2.0: other names, no variable of time, a step that returns True."""
    for old, new in {
        """        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
""": "",
        "from pythonfmu3 import Boolean, Float64, Fmi3Causality, Fmi3Slave, Fmi3Status, Fmi3StepResult, "
        "Fmi3Variability": "from pythonfmu import Boolean, Real, Fmi2Causality, Fmi2Slave, Fmi2Variability",
        "Float64": "Real",
        "Fmi3StepResult(status=Fmi3Status.ok)": "True",
        "Fmi3": "Fmi2",
    }.items():
        text = text.replace(old, new)
    return text


@pytest.fixture(scope="module")
def controllers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the controller of the page as FMUs by their versions."""
    found: dict[str, Path] = {}
    for version, builder, text in (
        ("3.0", Builder3, block("fmi.md")),
        ("2.0", Builder2, as_fmi2(block("fmi.md"))),
    ):
        folder = tmp_path_factory.mktemp("fmu")
        source = folder / f"square{version[0]}.py"
        source.write_text(text, "utf-8")
        found[version] = Path(builder.build_FMU(source, folder))
    return found


def ugv(client: virtualrobot.Client) -> virtualrobot.Client:
    client.scene.clear()
    client.load_robot("model://ugv", name="ugv", base="planar")
    return client


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu_drives_as_the_same_law_in_python_does(
    steps: virtualrobot.Client, controllers: dict[str, Path], tmp_path: Path, version: str
) -> None:
    program = tmp_path / "controller.py"
    program.write_text(block("lockstep.md"), "utf-8")
    ways: list[np.ndarray] = []
    for make in (lambda: FmuWire(controllers[version], PERIOD), lambda: ProgramWire([sys.executable, str(program)])):
        client = ugv(steps)
        seen: list[np.ndarray] = []
        wire = make()
        try:
            run = Lockstep(client, "ugv", PERIOD).run(
                wire, GUARD, 8.0, lambda _, seen=seen, client=client: seen.append(client.robot("ugv").tcp)
            )
        finally:
            wire.close()
        assert run.end == "the time is over"
        ways.append(np.array(seen))
    assert ways[0][-1, 0, 3] > 1.5  # it has got on
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-9)


def test_an_fmu_that_is_done_ends_the_run(steps: virtualrobot.Client, controllers: dict[str, Path]) -> None:
    ugv(steps)
    wire = FmuWire(controllers["3.0"], PERIOD)
    try:
        run = Lockstep(steps, "ugv", PERIOD).run(wire, GUARD)
    finally:
        wire.close()
    assert run.end == "the controller is done"
    assert np.hypot(*steps.robot("ugv").tcp[:2, 3]) < 0.1 + 0.15


def controller(folder: Path, body: str) -> Path:
    """Write an FMU with one input, one output and these lines of its step."""
    text = f"""from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave, Fmi3Status, Fmi3StepResult, Fmi3Variability


class Odd(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time, self.given, self.out = 0.0, 0.0, 0.0
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        self.register_variable(
            Float64("INPUT", causality=Fmi3Causality.input, getter=lambda: self.given, setter=lambda _: None),
            nested=False,
        )
        self.register_variable(
            Float64("OUTPUT", causality=Fmi3Causality.output, getter=lambda: self.out), nested=False
        )

    def do_step(self, current_time, step_size):
        {body}
        return Fmi3StepResult(status=Fmi3Status.ok)
"""
    names = {"INPUT": "robot.heading", "OUTPUT": "twist.vx"}
    for word, name in names.items():
        text = text.replace(f'"{word}"', f'"{name}"')
    source = folder / "odd.py"
    source.write_text(text, "utf-8")
    return Path(Builder3.build_FMU(source, folder))


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("import os; os.abort()", r"the controller has ended with (signal 6|exit code \d+)"),
        ("print('what it likes', flush=True); raise ValueError('of its own')", "the controller has failed in doStep"),
        ("self.out = float('nan')", "the controller's output 'twist.vx' is nan"),
    ],
)
def test_an_fmu_that_fails_is_told_and_the_robot_rests(
    steps: virtualrobot.Client, tmp_path: Path, body: str, words: str
) -> None:
    ugv(steps)
    wire = FmuWire(controller(tmp_path, body), PERIOD)
    try:
        with pytest.raises(WrongStateError, match=words):
            Lockstep(steps, "ugv", PERIOD).run(wire, GUARD)
    finally:
        wire.close()
    assert not steps.robot("ugv").state.velocities.any()


def test_an_fmu_whose_names_say_nothing_is_refused(
    steps: virtualrobot.Client, tmp_path: Path, controllers: dict[str, Path]
) -> None:
    with pytest.raises(MissingFileError, match="is not there"):
        FmuWire(tmp_path / "none.fmu", PERIOD)
    broken = tmp_path / "broken.fmu"
    broken.write_bytes(b"no zip")
    with pytest.raises(MalformedFileError, match=r"broken\.fmu is no FMU"):
        FmuWire(broken, PERIOD)

    renamed = tmp_path / "renamed.fmu"
    _renamed(controllers["3.0"], renamed, {"twist.vx": "speed", "twist.omega": "turn", 'name="done"': 'name="end"'})
    with pytest.raises(MalformedFileError, match=r"no output that is part of a command.*; it has speed, turn, end"):
        FmuWire(renamed, PERIOD)

    _renamed(controllers["3.0"], renamed, {"robot.heading": "robot.headin"})
    ugv(steps)
    wire = FmuWire(renamed, PERIOD)
    try:
        with pytest.raises(InvalidArgumentError, match=r"'robot.headin'; did you mean 'robot.heading'\?"):
            Lockstep(steps, "ugv", PERIOD).run(wire, GUARD)
    finally:
        wire.close()


def _renamed(file: Path, to: Path, words: dict[str, str]) -> None:
    """Copy an FMU with other words in its description."""
    with zipfile.ZipFile(file) as source, zipfile.ZipFile(to, "w") as out:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                for old, new in words.items():
                    data = data.replace(old.encode(), new.encode())
            out.writestr(name, data)


MASTER = """
import json, sys
import fmpy, numpy as np

file, names, stop, interval = sys.argv[1], json.loads(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])
driven = np.array([(0.0, 0.3, True), (stop, 0.3, True)], [("time", float), (names[0], float), ("signals.lamp", bool)])
told = fmpy.simulate_fmu(file, stop_time=stop, output_interval=interval, input=driven, output=names[1:])
print("TOLD", json.dumps([[float(value) for value in row] for row in told.tolist()]))
"""


def test_a_cell_is_stepped_by_another_master(
    steps: virtualrobot.Client, stepped_kernel: KernelProcess, tmp_path: Path
) -> None:
    """Each step of FMPy's master gives what the kernel's own client gets by the same steps."""

    def cell() -> virtualrobot.Robot:
        steps.scene.clear()
        arm = steps.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
        steps.signals.create("lamp", False, direction="input")
        return arm

    arm = cell()
    plan = plan_cell(steps, model="cell", command="velocities", address=stepped_kernel.address)
    joint = next(iter(arm.coordinates))
    assert [one.name for one in plan.variables if one.causality == INPUT] == [
        *(f"arm.command.{one}" for one in arm.coordinates),
        "signals.lamp",
    ]
    file = tmp_path / "cell.fmu"
    export_cell(plan, file)
    stop, interval, ticks = 0.4, 0.02, 5
    names = [f"arm.command.{joint}", f"arm.positions.{joint}", f"arm.velocities.{joint}", "arm.position[1]"]
    arguments = [str(file), json.dumps(names), str(stop), str(interval)]
    done = subprocess.run(
        [sys.executable, "-c", MASTER, *arguments],
        capture_output=True,
        text=True,
        timeout=GUARD,
        env={**os.environ, "VIRTUALROBOT_ADDRESS": stepped_kernel.address},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = [one for one in done.stdout.splitlines() if one.startswith("TOLD ")]
    told = np.array(json.loads(line.removeprefix("TOLD ")))
    assert steps.signals["lamp"] is True

    arm = cell()
    rows: list[list[float]] = []
    with steps.clock.hold_stepped():
        seen = steps.clock.step(1)
        for _ in range(round(stop / interval) + 1):
            state = seen.robots["arm"]
            rows.append([state.positions[0], state.velocities[0], state.world_t_tcp[0, 3]])
            velocities = {one: 0.3 if one == joint else 0.0 for one in arm.coordinates}
            seen = steps.clock.step(ticks, velocities={"arm": velocities})
        steps.clock.step(1, velocities={"arm": None})
    assert told[-1, 1] > 0.05  # it has moved
    # FMPy interpolates inputs, and so has 0.3 to the last bit alone.
    np.testing.assert_allclose(told[:, 1:], rows, rtol=0.0, atol=1e-12)


def test_what_makes_no_cell_is_refused(steps: virtualrobot.Client) -> None:
    steps.load_robot("model://ugv", name="ugv", base="planar")
    with pytest.raises(InvalidArgumentError, match="identifier"):
        plan_cell(steps, model="my cell")
    with pytest.raises(InvalidArgumentError, match=r"'ugv.imu' is no range sensor"):
        plan_cell(steps, sensors=["ugv.imu"])
    plan = plan_cell(steps, ["ugv"], sensors=["ugv.sonar_front"])
    inputs = [one.name for one in plan.variables if one.causality == INPUT]
    assert inputs == ["ugv.twist.vx", "ugv.twist.vy", "ugv.twist.omega"]
    assert any(one.name == "ugv.sonar_front.distances[1]" for one in plan.variables)
