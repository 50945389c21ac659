"""Settings with which programs of PolyScope begin: told by RTDE, taken where it is so anyway, or refused."""

from __future__ import annotations

import pytest

from tests.apps.languages.urscript_robot import Played

_PREAMBLE = """
  global _verified=0
  set_gravity([0.0, 0.0, 9.82])
  set_tcp(p[0.0,0.0,0.12,0.0,0.0,0.0])
  set_target_payload(0.5, [0.0, 0.0, 0.05], [0.001, 0.001, 0.001, 0.0, 0.0, 0.0])
  set_tool_communication(False, 115200, 0, 1, 1.5, 3.5)
  set_tool_output_mode(0)
  set_tool_digital_output_mode(0, 1)
  set_tool_digital_output_mode(1, 2)
  set_tool_voltage(24)
  set_safety_mode_transition_hardness(1)
  set_standard_analog_input_domain(0, 1)
  set_standard_analog_input_domain(1, 1)
  set_tool_analog_input_domain(0, 0)
  set_tool_analog_input_domain(1, 1)
  set_analog_outputdomain(0, 0)
  set_analog_outputdomain(1, 1)
  set_standard_digital_input_action(0, "default")
  set_runstate_tool_digital_output_to_value(1, 0)
  set_input_actions_to_default()
  steps = 0.0
  thread Step_Counter():
    while (True):
      steps = steps + 1.0
      sync()
    end
  end
  run Step_Counter()
"""


def test_a_program_as_polyscope_writes_it_runs() -> None:
    played = Played(
        _PREAMBLE
        + """
  global Waypoint_1_q=[.1, -1.57, 1.57, -1.57, -1.57, 0]
  global Waypoint_1_p=get_forward_kin(Waypoint_1_q)
  $ 2 "Robot Program"
  $ 4 "Waypoint_1" "breakAfter"
  movej(get_inverse_kin(Waypoint_1_p, qnear=Waypoint_1_q), a=1.3962634015954636, v=1.0471975511965976)
  set_payload_mass(0.7)
  set_payload_cog([0, 0, 0.06])
  set_analog_out(0, 0.5)
  set_standard_analog_out(1, 0.25)
  textmsg(get_standard_analog_out(1), get_standard_analog_in(0))
  textmsg(get_analog_out(0), get_analog_in(1))
"""
    )
    assert played.said == ["0.250", "0.50"]
    assert played.targets[-1, 0] == pytest.approx(0.1, abs=1e-6)
    told = played.controller.tell()
    names = "tool_output_voltage tool_output_mode tool_digital_output0_mode tool_digital_output1_mode"
    assert [told[name] for name in names.split()] == [24.0, 0, 1, 2]
    assert (told["tool_analog_input_types"], told["analog_io_types"]) == (0b10, 0b1011)
    assert (told["payload"], told["payload_cog"]) == (0.7, (0.0, 0.0, 0.06))
    assert (told["standard_analog_output0"], told["standard_analog_output1"]) == (pytest.approx(0.012), 2.5)


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("set_gravity([0, 9.82, 0])", "gravity of [0, 9.82, 0] can't be used here yet: [0, 0, 9.82] is taken"),
        ("set_tool_voltage(5)", "voltage is 0, 12 or 24, not 5"),
        ("set_tool_communication(True, 9600, 0, 1, 1.5, 3.5)", "a serial line of the tool can't be used here yet"),
        ("set_safety_mode_transition_hardness(0)", "a hardness of 0 can't be used here yet"),
        (
            "set_standard_analog_input_domain(0, 0)",
            "a domain of 0 can't be used here yet: an analog",
        ),
        ('set_tool_digital_input_action(0, "freedrive")', "an action of freedrive can't be used here yet"),
        ("set_runstate_standard_digital_output_to_value(1, 1)", "a state of 1 can't be used here yet"),
        ("set_standard_analog_out(0, 1.5)", "f is from 0 to 1, not 1.5"),
        ("set_standard_analog_out(2, 1)", "n is a whole number from 0 to 1, not 2"),
    ],
)
def test_a_setting_that_would_change_something_is_refused(statement: str, expected: str) -> None:
    (said,) = Played(statement).said
    assert expected in said
