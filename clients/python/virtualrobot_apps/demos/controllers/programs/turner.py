"""A client of a server in RAPID: it sends angles in degrees, and waits until the robot is there."""

import socket
import sys
import time

while True:
    try:
        robot = socket.create_connection((sys.argv[1], int(sys.argv[2])))
        break
    except ConnectionRefusedError:  # the robot's program has not begun yet
        time.sleep(0.1)
with robot:
    for angle in (30, -30, 0):
        robot.sendall(f"[{angle},0,0,0,30,0]".encode())
        try:
            answer = robot.recv(100).decode()
        except ConnectionError:
            answer = ""
        if not answer:
            print(f"the robot's program has ended on the way to {angle} degrees", flush=True)
            break
        print(f"{angle} degrees: {answer}", flush=True)
