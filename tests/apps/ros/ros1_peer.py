"""A program on rospy, actionlib and tf2 of Debian's, which are not ours; prints what it has heard as JSON.

Its argument is JSON: definitions of types that Debian lacks, and a goal for the arm.
"""
# Debian's Python runs it, whose packages are not those of the tests.
# pyright: reportMissingImports=false
# ruff: noqa: ANN001, ANN201, ANN202

import json
import sys
import threading

import actionlib
import genpy.dynamic
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool

GUARD = 60.0


def heard(topic, type, count=1):
    """Return so many messages of a topic."""
    found, done = [], threading.Event()

    def take(message):
        found.append(message)
        if len(found) == count:
            done.set()

    subscriber = rospy.Subscriber(topic, type, take, queue_size=1000)
    assert done.wait(GUARD), f"{topic}: {len(found)} of {count} messages"
    subscriber.unregister()
    return found[:count]


def acted(asked):
    """Return state and result of a goal, and how many feedbacks came, then the state of one that was cancelled."""
    types = {}
    for name, text in asked["definitions"].items():
        types |= genpy.dynamic.generate_dynamic(name, text)

    class Action:
        action_goal = types["control_msgs/FollowJointTrajectoryActionGoal"]()
        action_result = types["control_msgs/FollowJointTrajectoryActionResult"]()
        action_feedback = types["control_msgs/FollowJointTrajectoryActionFeedback"]()

    def goal(seconds):
        one = types["control_msgs/FollowJointTrajectoryGoal"]()
        one.trajectory.joint_names = asked["joints"]
        point = types["trajectory_msgs/JointTrajectoryPoint"](positions=asked["positions"])
        point.time_from_start = rospy.Duration(seconds)
        one.trajectory.points = [point]
        return one

    client = actionlib.SimpleActionClient("/arm/follow_joint_trajectory", Action)
    assert client.wait_for_server(rospy.Duration(GUARD))
    feedbacks = []
    client.send_goal(goal(1.0), feedback_cb=feedbacks.append)
    assert client.wait_for_result(rospy.Duration(GUARD))
    first = [client.get_state(), client.get_result().error_code, len(feedbacks) > 0]
    running = threading.Event()
    client.send_goal(goal(30.0), feedback_cb=lambda _: running.set())
    assert running.wait(GUARD)
    client.cancel_goal()
    assert client.wait_for_result(rospy.Duration(GUARD))
    sums = {name: type._md5sum for name, type in types.items() if name in asked["definitions"]}
    return {"first": first, "second": client.get_state(), "sums": sums}


def main():
    """Hear, tell, call and act, and print."""
    asked = json.loads(sys.argv[1])
    rospy.init_node("peer", anonymous=True, disable_signals=True)
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    states = heard("/arm/joint_states", JointState, 20)
    scan = heard("/scanner/scan", LaserScan)[0]
    info, image = heard("/eye/camera_info", CameraInfo)[0], heard("/eye/image_raw", Image)[0]
    frame = buffer.lookup_transform("world", asked["frame"], rospy.Time(0), rospy.Duration(GUARD)).transform
    told = {
        "states": [[one.header.stamp.to_nsec(), one.name, one.position] for one in states],
        "scan": [scan.angle_min, scan.angle_increment, scan.ranges],
        "camera": [info.K, info.width, image.width, image.encoding, len(image.data)],
        "description": heard("/arm/robot_description", String)[0].data,
        "parameter": rospy.get_param("/arm/robot_description"),
        "simulated": rospy.get_param("/use_sim_time"),
        "clock": heard("/clock", Clock)[0].clock.to_nsec(),
        "frame": [getattr(frame.translation, one) for one in "xyz"] + [getattr(frame.rotation, one) for one in "xyzw"],
        "switched": rospy.ServiceProxy("/switch", SetBool, persistent=True)(True).message,
    }
    try:
        rospy.ServiceProxy("/switch", SetBool)(False)
    except rospy.ServiceException as error:
        told["refused"] = str(error)
    rospy.set_param("~speed", {"fast": 1.5})
    told["private"] = [rospy.get_param("~speed/fast"), rospy.search_param("speed") == rospy.resolve_name("~speed")]
    wheels = rospy.Publisher("/ugv/cmd_vel", Twist, queue_size=10)
    moved = threading.Event()

    def take(one):
        if one.pose.pose.position.x > 0.05:
            moved.set()

    odom = rospy.Subscriber("/ugv/odom", Odometry, take)
    command = Twist()
    command.linear.x = 0.3
    while not moved.wait(0.05):
        wheels.publish(command)
    odom.unregister()
    if asked["definitions"]:
        told["action"] = acted(asked)
    told["topics"] = rospy.get_published_topics()
    del listener
    print(json.dumps(told))


main()
