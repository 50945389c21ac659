"""A program on rclpy, which is not ours: hears, tells, calls, and prints what came of it as JSON."""

import json
import sys
import time
from collections.abc import Callable

import rclpy  # pyright: ignore[reportMissingImports]  of a ROS 2
from rclpy.qos import DurabilityPolicy, QoSProfile  # pyright: ignore[reportMissingImports]
from sensor_msgs.msg import JointState  # pyright: ignore[reportMissingImports]
from std_msgs.msg import Bool, String  # pyright: ignore[reportMissingImports]
from std_srvs.srv import SetBool  # pyright: ignore[reportMissingImports]

GUARD = float(sys.argv[1])

rclpy.init()
node = rclpy.create_node("peer")


def until(is_so: Callable[[], object]) -> None:
    """Spin until something is so."""
    end = time.monotonic() + GUARD
    while not is_so():
        assert time.monotonic() < end, "it never came to be so"
        rclpy.spin_once(node, timeout_sec=0.05)


latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
descriptions: list[str] = []
node.create_subscription(String, "/arm/robot_description", lambda one: descriptions.append(one.data), latched)
until(lambda: descriptions)

states: list[list] = []
joints = node.create_subscription(
    JointState,
    "/arm/joint_states",
    lambda one: states.append([one.header.stamp.sec * 10**9 + one.header.stamp.nanosec, one.name, [*one.position]]),
    QoSProfile(depth=100),
)
until(lambda: len(states) >= 20)
node.destroy_subscription(joints)

lamps: list[bool] = []
node.create_subscription(Bool, "/signals/lamp", lambda one: lamps.append(one.data), latched)
lamp = node.create_publisher(Bool, "/signals/lamp/set", QoSProfile(depth=10))


def is_lit() -> bool:
    lamp.publish(Bool(data=True))
    return True in lamps


until(is_lit)

client = node.create_client(SetBool, "/switch")
until(client.service_is_ready)
answers = []
for wanted in (True, False):
    answer = client.call_async(SetBool.Request(data=wanted))
    until(answer.done)
    answers.append([answer.result().success, answer.result().message])

known = dict(node.get_topic_names_and_types())
print(
    json.dumps(
        {
            "description": descriptions[0],
            "states": states[:20],
            "switched": answers,
            "topics": known,
            "nodes": node.get_node_names(),
        }
    )
)
node.destroy_node()
rclpy.shutdown()
