"""A board that is computed, the other end of the line: it answers at a TCP port as a board would at a cable.

By itself it is a program, `python board.py`, which says the `port` for the settings: that of a pseudo terminal,
which is like a serial port, where the system has such.
"""

import contextlib
import os
import socketserver
import threading
import time

import serial

JOINTS, RATE, WATCHDOG_SECONDS = 3, 50.0, 1.0
SPEED = 60.0  # of a joint (degrees/s)


class Robot:
    """Its joints go to their goals at a limited speed; they move whenever somebody looks."""

    def __init__(self):
        self.positions = [10.0, -20.0, 30.0]
        self.points, self.goal, self.speed = [], list(self.positions), SPEED
        self.mode, self.done, self.looked, self.heard = "READY", 0, time.perf_counter(), 0.0
        self.trouble = ""

    def look(self):
        now = time.perf_counter()
        step, self.looked = self.speed * (now - self.looked), now
        pairs = list(zip(self.positions, self.goal, strict=True))
        self.positions = [p + min(max(g - p, -step), step) for p, g in pairs]
        if self.points and self.positions == self.goal:
            self.points.pop(0)
            self.done += 1
            self.next()

    def next(self):
        if self.points:
            self.speed, self.goal = self.points[0]

    def halt(self, mode):
        self.look()
        self.points, self.goal, self.speed, self.mode = [], list(self.positions), SPEED, mode

    def answer(self, kind, *words):
        """Return the answer to a line; README.md has the table."""
        if self.mode == "RUNNING" and not self.points and time.perf_counter() - self.heard > WATCHDOG_SECONDS:
            self.halt("READY")
        self.look()
        self.heard = time.perf_counter()
        if kind == "hello":
            self.halt("READY")
            return f"board {JOINTS} {RATE} {WATCHDOG_SECONDS}"
        if kind == "reset" and self.trouble == "hot":
            self.trouble = ""
        if self.trouble == "hot" and kind in ("on", "go", "move", "read"):
            self.halt("READY")
            return "error 12 motor 2 is hot"
        if kind == "read":
            return f"at {self.looked} {self.mode} {self.done} {' '.join(map(str, self.positions))}"
        if kind == "on":
            self.halt("RUNNING")
            self.done = 0
        elif kind == "go" and self.mode == "RUNNING":
            self.goal = [float(word) for word in words]
        elif kind == "move" and self.mode == "RUNNING":
            speed, *goal = (float(word) for word in words)
            self.points.append((speed / 100.0 * SPEED, goal))
            if len(self.points) == 1:
                self.next()
        elif kind in ("stop", "off"):
            self.halt("READY")
        return "ok"


class Board(socketserver.ThreadingTCPServer):
    """Owns a robot and answers for it; every connection is a cable."""

    allow_reuse_address = daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Cable)
        self.robot, self.lock = Robot(), threading.Lock()
        self.port = f"socket://127.0.0.1:{self.server_address[1]}"
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def reply(self, line):
        """Return what comes back for a line: nothing where the board is silent, None where the cable is broken."""
        kind, *words = line.decode("ascii", "replace").split() or [""]  # noise is a line, too
        with self.lock:
            if kind == "pretend":
                (self.robot.trouble,) = words
                return b"ok\n"
            if self.robot.trouble == "broken":
                return None
            answer = self.robot.answer(kind, *words)
            return b"" if self.robot.trouble == "silent" else f"{answer}\n".encode()


class Cable(socketserver.StreamRequestHandler):
    def handle(self):
        with contextlib.suppress(ConnectionError):
            for line in self.rfile:
                answer = self.server.reply(line)
                if answer is None:
                    return
                self.wfile.write(answer)


def pseudo_terminal(board):
    """Return a serial port at which the board answers too; there are such on Linux and macOS."""
    import tty

    ours, theirs = os.openpty()
    tty.setraw(theirs)

    def serve():
        with open(ours, "rb", buffering=0) as lines:
            for line in lines:
                os.write(ours, board.reply(line) or b"")

    threading.Thread(target=serve, daemon=True).start()
    return os.ttyname(theirs)


def pretend(driver, trouble):
    """Give the driver's board a trouble, by a cable of its own."""
    with serial.serial_for_url(driver.settings.port, timeout=60.0) as line:
        line.write(f"pretend {trouble}\n".encode())
        line.readline()


def break_cable(driver):
    pretend(driver, "broken")


def freeze(driver):
    pretend(driver, "silent")


def heat(driver):
    pretend(driver, "hot")


def mend(driver):
    pretend(driver, "none")


if __name__ == "__main__":
    board = Board()
    print(pseudo_terminal(board) if hasattr(os, "openpty") else board.port, flush=True)
    threading.Event().wait()
