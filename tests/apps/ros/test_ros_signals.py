"""Signals as topics, with roslibpy: each value as its message, changes in order, and what sets them."""

from __future__ import annotations

import roslibpy
from virtualrobot import Client

from tests.apps.ros.bridges import Heard, bridge, roslibpy_client, told
from tests.waiting import until

SIGNALS = {"gripper closed": True, "parts": 7, "cell.pressure": 5.5, "line": "é", "lamps": (True, False, True)}
TOLD = {
    "/signals/gripper_closed": ("std_msgs/Bool", True),
    "/signals/parts": ("std_msgs/Int64", 7),
    "/signals/cell/pressure": ("std_msgs/Float64", 5.5),
    "/signals/line": ("std_msgs/String", "é"),
    "/signals/lamps": ("std_msgs/UInt8MultiArray", "AQAB"),  # bytes 1, 0, 1 in base64, as rosbridge has bytes
}


def test_signals_are_told_and_set(client: Client) -> None:
    for name, value in SIGNALS.items():
        client.signals.create(name, value)
    try:
        with bridge(client) as (url, said), roslibpy_client(url) as ros:
            heard = {name: Heard(ros, name, type) for name, (type, _) in TOLD.items()}
            assert {name: one.next()["data"] for name, one in heard.items()} == {
                name: value for name, (_, value) in TOLD.items()
            }

            for number in range(8, 12):
                client.signals["parts"] = number
            parts = heard["/signals/parts"]
            assert [one["data"] for one in parts.until(lambda one: one["data"] == 11)] == [8, 9, 10, 11]

            setting = roslibpy.Topic(ros, "/signals/lamps/set", "std_msgs/UInt8MultiArray")
            setting.publish(roslibpy.Message({"data": [0, 1, 1]}))
            until(lambda: client.signals["lamps"] == (False, True, True))
            setting.publish(roslibpy.Message({"data": [1]}))  # the kernel refuses a group of another length
            until(lambda: any(one.startswith("the signal 'lamps' is not set: ") for one in said))

            heard["/signals/line"].topic.unsubscribe()  # else the topic stays, and keeps its type
            del client.signals["line"]
            until(lambda: "/signals/line" not in told(ros.get_topics()))
            client.signals.create("line", 2.5)
            until(lambda: "/signals/line" in told(ros.get_topics()))
            assert told(ros.get_topic_type("/signals/line")) in ("std_msgs/Float64", "std_msgs/msg/Float64")
    finally:
        for name in SIGNALS:
            client.signals.pop(name, None)
