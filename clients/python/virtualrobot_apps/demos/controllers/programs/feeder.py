"""A program with abb-robot-client: it loads a module into a controller, starts it, and waits for its end."""

import sys
import time
from pathlib import Path

from abb_robot_client.rws import RWS

robot = RWS(sys.argv[1])
robot.upload_file("$HOME/feeder.mod", Path(__file__).with_name("feeder.mod").read_bytes())
robot._do_post("rw/rapid/tasks/T_ROB1?action=loadmod", {"modulepath": "$HOME/feeder.mod", "replace": "true"})
robot.resetpp()
robot.start(cycle="once")
while robot.get_execution_state().ctrlexecstate == "running":
    time.sleep(0.1)
print(f"{robot.get_rapid_variable('parts')} parts are fed")
