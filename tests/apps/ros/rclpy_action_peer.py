"""A program on rclpy's ActionClient, which is not ours: sends goals, cancels one, and prints what came as JSON."""

import json
import sys
from typing import Any

import rclpy  # pyright: ignore[reportMissingImports]  of a ROS 2
from rclpy.action import ActionClient  # pyright: ignore[reportMissingImports]
from test_msgs.action import Fibonacci  # pyright: ignore[reportMissingImports]

GUARD = float(sys.argv[1])

rclpy.init()
node = rclpy.create_node("peer")
client = ActionClient(node, Fibonacci, "/fibonacci")
assert client.wait_for_server(timeout_sec=GUARD)


def ended(future: Any) -> Any:  # noqa: ANN401 classes of rclpy
    """Return what a future brings."""
    rclpy.spin_until_future_complete(node, future, timeout_sec=GUARD)
    assert future.done(), "it never came to an end"
    return future.result()


told: list[list[int]] = []
counted = ended(
    client.send_goal_async(Fibonacci.Goal(order=6), feedback_callback=lambda one: told.append([*one.feedback.sequence]))
)
result = ended(counted.get_result_async())
long = ended(client.send_goal_async(Fibonacci.Goal(order=1000)))
cancelled = ended(long.cancel_goal_async())
rest = ended(long.get_result_async())
print(
    json.dumps(
        {
            "accepted": [counted.accepted, long.accepted],
            "statuses": [result.status, rest.status],
            "sequence": [*result.result.sequence],
            "feedback": told,
            "cancelled": len(cancelled.goals_canceling),
        }
    )
)
node.destroy_node()
rclpy.shutdown()
