"""A client of a real kernel, with an empty world for each test."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import virtualrobot
from virtualrobot import cli

from tests.kernels import KernelProcess
from tests.pybullet_models import MODELS as MODELS

IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
PANDA = "package://pybullet_data/franka_panda/panda.urdf"

Run = Callable[..., str]


@pytest.fixture
def iiwa(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an arm with seven joints."""
    return client.load_robot(IIWA, name="iiwa")


@pytest.fixture
def environment(kernel: KernelProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let commands find the kernel of these tests."""
    monkeypatch.setenv("VIRTUALROBOT_ADDRESS", kernel.address)


@pytest.fixture
def run(client: virtualrobot.Client, environment: None, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command and gives its output; a refusal (`code`) gives its one line.

    With `warns` the command succeeds with so many lines of warnings, which come after its output.
    """

    def run(*arguments: str, code: int = 0, warns: int = 0) -> str:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main(arguments)
        captured = capsys.readouterr()
        lines = 1 if code else warns
        assert (ended.value.code, captured.err.count("\n")) == (code, lines), captured.err
        return captured.err if code else captured.out + captured.err

    return run
