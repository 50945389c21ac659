"""A program on zenoh_ros2_sdk, which is not ours: hears, tells, calls, and prints what came of it as JSON.

Its arguments are the router's port and the domain. The package knows simple messages; joints are read by zenoh and
rosbags' types of Jazzy, under the key that rmw_zenoh gives them.
"""

import json
import sys
import time
from queue import Queue
from typing import Any

from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2Subscriber
from zenoh_ros2_sdk.session import ZenohSession

PORT, DOMAIN = int(sys.argv[1]), int(sys.argv[2])
GUARD = 60.0
JOINTS = "sensor_msgs::msg::dds_::JointState_/RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
PLACE: dict[str, Any] = {"domain_id": DOMAIN, "router_port": PORT}
SWITCH = {"request_definition": "bool data\n", "response_definition": "bool success\nstring message\n"}

came: Queue = Queue()
description = ROS2Subscriber(
    "/arm/robot_description", "std_msgs/msg/String", came.put, msg_definition="string data\n", **PLACE
)
told = {"description": came.get(timeout=GUARD).data}

session = ZenohSession.get_instance(router_port=PORT).session
joints: Queue = Queue()
reader = session.declare_subscriber(f"{DOMAIN}/arm/joint_states/{JOINTS}", joints.put)
# A node of ROS 2 says that it reads.
token = session.liveliness().declare_token(
    f"@ros2_lv/{DOMAIN}/{session.info.zid()}/90/91/MS/%/%/reader/%arm%joint_states/{JOINTS}/::,10:,:,:,,"
)
store = get_typestore(Stores.ROS2_JAZZY)
found, numbers = [], []
for _ in range(20):
    sample = joints.get(timeout=GUARD)
    state: Any = store.deserialize_cdr(sample.payload.to_bytes(), "sensor_msgs/msg/JointState")
    found.append([state.header.stamp.sec * 10**9 + state.header.stamp.nanosec, state.name, state.position.tolist()])
    numbers.append(int.from_bytes(sample.attachment.to_bytes()[:8], "little"))
told |= {"states": found, "numbers": numbers}
token.undeclare()

lamp = ROS2Publisher("/signals/lamp/set", "std_msgs/msg/Bool", msg_definition="bool data\n", **PLACE)
heard: Queue = Queue()
signal = ROS2Subscriber("/signals/lamp", "std_msgs/msg/Bool", heard.put, msg_definition="bool data\n", **PLACE)
session.put(lamp.keyexpr, b"no message")
until = time.monotonic() + GUARD
on = False
while not on and time.monotonic() < until:
    lamp.publish(data=True)
    time.sleep(0.05)
    while not heard.empty():
        on = on or bool(heard.get().data)
told["lamp"] = on

client = ROS2ServiceClient("/switch", "std_srvs/srv/SetBool", timeout=GUARD, **SWITCH, **PLACE)
answers: list[Any] = [client.call(data=one) for one in (True, False)]
told["switched"] = [[one.success, one.message] for one in answers if one is not None]
# A request without what ROS 2 sends along.
told["bare"] = [one.err.payload.to_string() for one in session.get(client.keyexpr, payload=b"") if one.err]
told["tokens"] = [
    str(reply.ok.key_expr)
    for reply in session.liveliness().get(f"@ros2_lv/{DOMAIN}/**")
    if reply.ok is not None and "/virtualrobot" in str(reply.ok.key_expr)
]
print(json.dumps(told))
for one in (description, lamp, signal, client):
    one.close()
ZenohSession.get_instance(router_port=PORT).session.close()
