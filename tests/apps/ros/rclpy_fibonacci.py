"""An action of test_msgs, which ROS 2's wheels have, on a hub that is a node by rclpy, until standard input ends."""

import asyncio
import sys
import tempfile
from pathlib import Path

import numpy as np
from virtualrobot_apps.bridges.ros.hub import CANCELED, SUCCEEDED, Action, Feedback, Hub
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.types import make, replace
from virtualrobot_apps.bridges.ros.rclpy_node import RclpyNode

TYPE = "test_msgs/action/Fibonacci"
DEFINITION = """
test_msgs:
  action:
    Fibonacci: {goal: [int32 order], result: ["int32[] sequence"], feedback: ["int32[] sequence"]}
"""


async def count(goal: RosValue, feedback: Feedback, cancel: asyncio.Event) -> tuple[int, RosValue]:
    """Tell the sequence as it grows; of more than a hundred numbers none come until it is cancelled."""
    sequence = [0, 1]
    if goal.order > 100:
        await cancel.wait()
        return CANCELED, make(f"{TYPE}_Result", sequence=np.array(sequence, np.int32))
    while len(sequence) <= goal.order:
        sequence.append(sequence[-1] + sequence[-2])
        feedback(make(f"{TYPE}_Feedback", sequence=np.array(sequence, np.int32)))
    return SUCCEEDED, make(f"{TYPE}_Result", sequence=np.array(sequence, np.int32))


async def main() -> None:
    hub, node = Hub(), RclpyNode(name="counter")
    hub.act(Action("/fibonacci", TYPE, count))
    print(await node.open(hub), flush=True)
    await asyncio.to_thread(sys.stdin.read)
    await node.close()


with tempfile.TemporaryDirectory() as folder:
    (file := Path(folder) / "types.yaml").write_text(DEFINITION)
    replace(file)
asyncio.run(main())
