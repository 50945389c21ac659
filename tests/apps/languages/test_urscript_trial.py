"""Scripts in URScript that are tried before a robot sees them: what they touch, can't reach or never end, by line."""

from __future__ import annotations

import socket
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.languages.urscript.command import urscript

pytestmark = pytest.mark.long

HOME = (0.0, -1.57, 1.57, -1.57, -1.57, 0.0)
SCRIPT = """def job():
  movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
  if socket_open("127.0.0.1", {port}):
    movej([0, 3, 0, 0, 0, 0])
  end
  if get_standard_digital_in(3):
    movej([1.2, -1.57, 1.57, -1.57, -1.57, 0], a=3, v=2)
  end
  if get_standard_digital_in(4):
    movel(p[3, 0, 0.3, 0, 3.14, 0])
  end
  while get_standard_digital_in(5):
    sync()
  end
end
"""


def test_a_script_is_tried_and_nothing_moves(client: virtualrobot.Client, tmp_path: Path) -> None:
    """A box stands where the tool is halfway of the move in line 7; an arm of 0.85 m doesn't reach 3 m."""
    arm = client.load_robot("model://ur5e", name="arm")
    arm.set_positions(HOME)
    halfway = dict(zip(arm.joint_names, (0.6, *HOME[1:]), strict=True))
    client.scene.add_object("box", [virtualrobot.box(0.1, 0.1, 0.1)], pose=arm.solve_forward(halfway).world_t_tcp)
    file = tmp_path / "job.script"

    def tried(*options: str) -> tuple[int, list[str]]:
        """Return the exit code, and the lines behind the first one."""
        asked = ["check", str(file), "--run", "--address", client.address, *options]
        done = CliRunner().invoke(urscript, asked, standalone_mode=False)
        assert done.exception is None, done.output
        return done.return_value, done.output.replace(f"{file}:", "").splitlines()[1:]

    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        file.write_text(SCRIPT.format(port=server.getsockname()[1]))
        code, said = tried()
        assert (code, len(said)) == (0, 1) and said[0].startswith("no fault in a run of ")
        with pytest.raises(BlockingIOError):
            server.accept()
        code, said = tried("--order", "input 3 on", "--times", "--order", "input 4 on")
        assert code == 1 and said[-1].startswith("2 faults in a run of ")
        touches, far = sorted(said[:2], key=lambda line: "touches" not in line)
        assert touches.startswith("7:5: 'arm.") and touches.endswith(" touches 'box'")
        assert far.startswith("10:5: ")
        # By hand: 1.2 rad with 2 rad/s and 3 rad/s^2 are 1.2 / 2 + 2 / 3 s.
        (seven,) = (float(line.split()[0]) for line in said if line.endswith(" s  7"))
        assert seven == pytest.approx(1.2 / 2.0 + 2.0 / 3.0, abs=0.2)
        code, said = tried("--order", "input 5 on", "--longest", "2")
        assert (code, said[0]) == (1, "2:3: the script has not ended after 2 s")
        file.write_text("def press():\n  zero_ftsensor()\nend\n")
        code, said = tried()
        assert code == 1 and said[0].startswith("2:3: 'zero_ftsensor' needs forces, and a trial feels none; ")
    np.testing.assert_array_equal(arm.state.positions, HOME)
    done = CliRunner().invoke(urscript, ["check", str(file), "--run", "--address", client.address, "--order", "jump"])
    assert done.exit_code == 1 and "'jump' is none of" in done.output
