"""Runs that are over as recordings, made by replaying what a project folder has kept."""

from __future__ import annotations

from pathlib import Path

import pytest
import virtualrobot
from mcap.reader import make_reader
from pyarrow import parquet
from virtualrobot import cli
from virtualrobot.recording.export import export_run
from virtualrobot.recording.recording import Recording

from tests.kernels import StartKernel

ROWS = [{"a": 0.4, "limits": (-2.0, 2.0)}, {"a": 0.3, "limits": (-2.0, 2.0)}]
TICKS = 40


@pytest.fixture(scope="module")
def run(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the project `data` of a kernel that has ended, and what was recorded of it: live.mcap."""
    folder = tmp_path_factory.mktemp("run")
    kernel = start_kernel("--stepped", "--data", str(folder / "data"))
    with virtualrobot.connect(kernel.address) as client:
        with client.start_recording(folder / "live.mcap", topics=["/robots/*", "/signals/*"]) as recording:
            recording.step()
            arm = client.load_denavit_hartenberg(ROWS, convention="standard", name="arm")
            client.signals.create("pressure", 1.5, unit="bar")
            arm.move_joints([0.5, -0.4], wait=False, on_disconnect="continue")
            recording.step(TICKS)
            client.signals["pressure"] = 2.5
            recording.step()
    assert kernel.end() == 0
    return folder


def read(path: Path) -> dict[str, set[tuple[int, bytes]]]:
    """Return the messages of an MCAP file by topic, each with its time (ns)."""
    found: dict[str, set[tuple[int, bytes]]] = {}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            found.setdefault(channel.topic, set()).add((message.log_time, message.data))
    return found


@pytest.mark.long
def test_what_was_recorded_is_exported_again_from_the_journal(run: Path) -> None:
    recorded = export_run(run / "data", run / "past.mcap", topics=["/robots/*", "/signals/*"])
    live, past = read(run / "live.mcap"), read(run / "past.mcap")
    assert past == live
    assert len(past["/robots/arm/joint_states"]) == TICKS + 2
    assert recorded.missed_ticks == 0 and recorded.end - recorded.start == pytest.approx((TICKS + 2) * 0.004)


@pytest.mark.long
def test_a_part_of_a_run_becomes_a_table(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = run / "part.parquet"
    options = [
        "--from",
        "0",
        "--to",
        "0.08",
        "--rate",
        "50",
        "--topics",
        "arm/*/position",
        "--topics",
        "/signals/*",
        "--topics",
        "arn/*",
    ]
    with pytest.raises(SystemExit) as ended:
        cli.main(["export", str(run / "data"), str(path), *options])
    said = capsys.readouterr()
    assert ended.value.code == 0 and f"{path}: 0.080 s from 0.000 s on" in said.out
    assert said.err.startswith("nothing came of 'arn/*'; there are '/robots/arm/joint_states', ")
    table = parquet.read_table(path)
    # The columns are those of what came later, too: at the begin there was no arm.
    assert sorted(table.column_names) == [
        "arm/joint_1/position",
        "arm/joint_2/position",
        "signals/pressure",
        "tick",
        "time",
    ]
    ticks = table["tick"].to_pylist()
    assert ticks == sorted(set(ticks)) and {5, 10, 15, 20} <= set(ticks)


@pytest.mark.long
def test_an_export_that_is_interrupted_leaves_a_whole_file(run: Path) -> None:
    def told(recording: Recording, seconds: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export_run(run / "data", run / "begin.mcap", end=0.12, rate=125.0, topics=["/robots/*"], told=told)
    live, past = read(run / "live.mcap"), read(run / "begin.mcap")
    joints = past["/robots/arm/joint_states"]
    assert joints and joints <= live["/robots/arm/joint_states"]


@pytest.mark.long
def test_what_cannot_be_exported_is_refused(run: Path, tmp_path: Path) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="begin is 7 s; what is kept goes from 0 to 0"):
        export_run(run / "data", tmp_path / "run.mcap", begin=7.0)
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"ends after it begins: from 0\.1 to 0\.04 s"):
        export_run(run / "data", tmp_path / "run.mcap", begin=0.1, end=0.04)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="is no recording"):
        export_run(run / "data", tmp_path / "run.txt")
    assert not list(tmp_path.iterdir())


def test_what_is_no_folder_is_refused_in_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["export", str(tmp_path), str(tmp_path / "run.mcap")])
    said = capfd.readouterr().err
    assert ended.value.code != 0 and not list(tmp_path.iterdir())
    assert said.count("\n") == 1 and f"{tmp_path} is no project folder, it has no project.json" in said
    assert "replay" not in said
