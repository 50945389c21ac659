"""Program files are read against the schema of the contract; errors name file, line and path."""

from __future__ import annotations

import pytest
from virtualrobot._wire.signal_values import value_message
from virtualrobot.v1 import motion_pb2
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.program_file import parse

PROGRAM = """\
schema_version: 1
tracking: {node: belt, window: 0.5}
steps:
  - move:
      moves:
        - {robot: arm, time_law: TIME_LAW_JERK_LIMITED, point_to_point: {posture: home}}
      blend_distance_meters: 0.02
  - set_signal: {signal: on, value: {boolean: true}}
  - wait_signal: {condition: {signal: "5", value: {boolean: false}}, timeout_seconds: 2}
  - dwell:
      seconds: 0.1
"""


def test_a_program_is_the_message_of_the_contract() -> None:
    move = motion_pb2.Move(
        robot="arm",
        time_law=motion_pb2.TIME_LAW_JERK_LIMITED,
        point_to_point=motion_pb2.PointToPoint(posture="home"),
    )
    condition = motion_pb2.SignalCondition(signal="5", value=value_message(False))
    assert parse(PROGRAM) == motion_pb2.MotionSpec(
        tracking=motion_pb2.Tracking(node="belt", window=0.5),
        steps=[
            motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move], blend_distance_meters=0.02)),
            motion_pb2.ProgramStep(set_signal=motion_pb2.SetSignalStep(signal="on", value=value_message(True))),
            motion_pb2.ProgramStep(wait_signal=motion_pb2.WaitSignalStep(condition=condition, timeout_seconds=2)),
            motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.1)),
        ],
    )
    assert parse('{"schema_version": 1, "moves": [{"robot": "arm"}]}').moves[0].robot == "arm"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("seconds: 0.1", "secnds: 0.1"), "cell.yaml:11: steps[3].dwell: there is no field 'secnds'; did you mean"),
        (
            ("boolean: true", "boolean: yes"),
            "cell.yaml:8: steps[1].set_signal.value.boolean: expected true or false, got 'yes'",
        ),
        (("- dwell:", "- set_signal: {}\n    dwell:"), "only one step may be given; there is 'set_signal' too"),
        (("steps:", "stps:"), "cell.yaml:3: the program: there is no field 'stps'; did you mean 'steps'"),
        (("schema_version: 1", ""), "a program file begins with `schema_version: 1`"),
        (("schema_version: 1", "schema_version: 2"), "unknown version '2'; this kernel reads version 1"),
        (("JERK_LIMITED", "SLOW"), "is no TimeLaw"),
        (("seconds: 0.1", "seconds: .nan"), "cell.yaml:11: steps[3].dwell.seconds: expected a number"),
    ],
)
def test_errors_name_line_and_path(change: tuple[str, str], words: str) -> None:
    with pytest.raises(MalformedFileError) as refused:
        parse(PROGRAM.replace(*change), "cell.yaml")
    assert words in str(refused.value)


def test_an_empty_file_says_what_it_lacks() -> None:
    with pytest.raises(MalformedFileError, match="begins with"):
        parse("")
