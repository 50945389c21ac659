"""The microcontroller's side of `serial_line`: six hobby servos, moved by lines of text over the USB cable.

For MicroPython (a Raspberry Pi Pico, an ESP32): save it on the board as main.py. What a line means stands in
docs/drivers/serial_line.md. Servos with other pulses, pins or limits need other constants below, and nothing else.
"""

import select
import sys
import time

from machine import PWM, Pin

PINS = (0, 1, 2, 3, 4, 5)
LOWER, UPPER = -90.0, 90.0
MIDDLE_NS, NS_A_DEGREE = 1500000, 1000000 / 90
SPEED = 120.0  # degrees a second, of the fastest joint
RATE = 20
WATCHDOG_MS = 500
JOBS = False  # True: it goes to points by itself, up to QUEUE of them one after the other
QUEUE = 4
LAMP = Pin(25, Pin.OUT)
BUTTON = Pin(15, Pin.IN, Pin.PULL_UP)

servos = [PWM(Pin(pin), freq=50) for pin in PINS]
positions = [0.0] * len(PINS)
points = []  # (share of the speed, goal): where it goes to, one after the other
done = 0
on = False


def check(line):
    """Return the four digits after the asterisk: CRC-16, XMODEM."""
    total = 0
    for letter in line:
        total ^= ord(letter) << 8
        for _ in range(8):
            total = (total << 1 ^ (0x1021 if total & 0x8000 else 0)) & 0xFFFF
    return "%04X" % total


def answer(line):
    """Do what a line says, and return what is said to it."""
    global on, done
    line, star, digits = line.rpartition("*") if "*" in line else (line, "", "")
    words = line.split()
    if not words or (star and digits != check(line)):
        return "ERR 1 not understood"
    word, rest = words[0], words[1:]
    if word == "HELLO":
        on = False
        pace = "JOBS QUEUE %d" % QUEUE if JOBS else "HOST"
        about = "JOINTS %d RATE %d UNIT DEG PACE %s WATCHDOG %g" % (len(PINS), RATE, pace, WATCHDOG_MS / 1000)
        return about + " INPUTS 1 OUTPUTS 1 MODEL six-servos VERSION 1 CHECK 1"
    if word == "READ":
        state = "RUNNING" if on else "READY"
        values = " ".join("%.3f" % value for value in positions)
        return "AT %d %s %d %d %s" % (time.ticks_ms(), state, done, 1 - BUTTON.value(), values)
    if word == "ON":
        on, done = True, 0
        points.clear()
        show()
    elif word == "STOP":
        on = False
    elif word == "OUT":
        LAMP.value(int(rest[0]) & 1)
    elif word in ("GO", "MOVE"):
        if not on:
            return "ERR 2 it does not follow: ON comes first"
        numbers = [float(one) for one in rest]
        count, share = 0, 1.0
        if word == "MOVE":
            count, share, numbers = int(numbers[0]), numbers[1] / 100, numbers[2:]
        if len(numbers) != len(PINS):
            return "ERR 3 %d joints, not %d" % (len(PINS), len(numbers))
        for i, number in enumerate(numbers):
            if not LOWER <= number <= UPPER:
                return "ERR 4 joint %d to %g: it goes from %g to %g" % (i + 1, number, LOWER, UPPER)
        expected = done + len(points) + 1
        if word == "GO":
            points.clear()
        elif count > expected or (count == expected and len(points) >= QUEUE):
            return "ERR 5 point %d: %d of %d wait, and %d comes next" % (count, len(points), QUEUE, expected)
        if word == "GO" or count == expected:  # else it is known already
            points.append((share, numbers))
    elif word != "RESET":
        return "ERR 1 not understood"
    return "OK " + word


def answered(line):
    """Return the answer with its check where the line had one."""
    try:
        said = answer(line)
    except (ValueError, IndexError):
        said = "ERR 1 not understood"
    return said + "*" + check(said) if "*" in line else said


def show():
    """Give the servos the positions."""
    for servo, position in zip(servos, positions):
        servo.duty_ns(int(MIDDLE_NS + position * NS_A_DEGREE))


def move(seconds):
    """Go towards the first point, all joints at once; when it is reached, the next one's turn has come."""
    global done
    if not (on and points):
        return
    share, goal = points[0]
    way = max([abs(there - here) for there, here in zip(goal, positions)])
    part = min(1.0, SPEED * share * seconds / way) if way > 0 else 1.0
    for i in range(len(positions)):
        positions[i] += part * (goal[i] - positions[i])
    show()
    if part == 1.0:
        points.pop(0)
        done += 1


def run():
    """Answer each line as it ends, and move every 5 ms; stop when nobody has said anything for a while."""
    global on
    letters = select.poll()
    letters.register(sys.stdin, select.POLLIN)
    line = ""
    moved = heard = time.ticks_ms()
    while True:
        if letters.poll(5):
            letter = sys.stdin.read(1)
            if letter == "":
                return
            if letter not in "\r\n":
                line = (line + letter)[-250:]
            elif line:
                heard = time.ticks_ms()
                print(answered(line))
                line = ""
        now = time.ticks_ms()
        if time.ticks_diff(now, heard) > WATCHDOG_MS:
            on = False
        if time.ticks_diff(now, moved) >= 5:
            move(time.ticks_diff(now, moved) / 1000)
            moved = now


run()
