"""Dynamixel servos that are computed, written from the e-Manual: protocol 2.0 and the control table of the X series.

The library of their makers has the other end, and shares no line with this.
"""

from __future__ import annotations

import time

PING, READ, WRITE, REBOOT, STATUS, SYNC_READ, SYNC_WRITE = 0x01, 0x02, 0x03, 0x08, 0x55, 0x82, 0x83
INSTRUCTION, LENGTH, LIMIT, ACCESS = 2, 5, 6, 7
"""Errors of a status packet: unknown instruction, wrong length, out of limits, no access."""
OPERATING_MODE, MAX_LIMIT, MIN_LIMIT, TORQUE, HARDWARE_ERROR, WATCHDOG, GOAL = 11, 48, 52, 64, 70, 98, 116
TICK, VELOCITY, POSITION, END = 120, 128, 132, 147


def crc(data: bytes) -> int:
    """Return the check of a packet: CRC-16 with the polynomial x^16 + x^15 + x^2 + 1, highest bit first, from 0."""
    value = 0
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ (0x8005 if value & 0x8000 else 0)) & 0xFFFF
    return value


class Servo:
    """A servo that turns to its goal at a constant speed."""

    def __init__(self, number: int, position: int = 2048, speed: float = 8000.0) -> None:
        """Stand at a position (pulses); `speed` is in pulses a second."""
        self.number, self.speed = number, speed
        self.at = float(position)
        self.started = self.moved = self.heard = time.monotonic()
        self.table = bytearray(END)
        self.answers = True
        for address, length, value in (
            *((0, 2, 1060), (6, 1, 45), (7, 1, number), (9, 1, 250), (OPERATING_MODE, 1, 3)),
            *((MAX_LIMIT, 4, 4095), (MIN_LIMIT, 4, 0), (68, 1, 2), (GOAL, 4, position)),
        ):
            self.put(address, length, value)

    def put(self, address: int, length: int, value: int) -> None:
        """Set a number of the table."""
        self.table[address : address + length] = value.to_bytes(length, "little", signed=value < 0)

    def get(self, address: int, length: int) -> int:
        """Return a number of the table."""
        return int.from_bytes(self.table[address : address + length], "little", signed=length == 4)

    def advance(self) -> None:
        """Turn for the time that has passed."""
        now = time.monotonic()
        passed, self.moved = now - self.moved, now
        watchdog = self.table[WATCHDOG]
        if 0 < watchdog < 128 and now - self.heard > watchdog * 0.02:
            self.table[WATCHDOG] = 0xFF
        self.heard = now
        before = self.at
        if self.table[TORQUE] and self.table[WATCHDOG] != 0xFF:
            way = self.get(GOAL, 4) - self.at
            self.at += max(-self.speed * passed, min(self.speed * passed, way))
        velocity = (self.at - before) / passed if passed > 0 else 0.0
        self.put(VELOCITY, 4, round(velocity / (0.229 / 60 * 4096)))
        self.put(POSITION, 4, round(self.at))
        self.put(TICK, 2, int((now - self.started) * 1000) % 2**15)

    def overload(self) -> None:
        """Have the error that a blocked joint gives: no torque until it begins anew."""
        self.table[HARDWARE_ERROR] = 1 << 5
        self.table[TORQUE] = 0

    def write(self, address: int, data: bytes) -> int:
        """Write to the table, and return the error."""
        if address < TORQUE and self.table[TORQUE]:
            return ACCESS
        if address == TORQUE and self.table[HARDWARE_ERROR]:
            return ACCESS
        if address == GOAL:
            if self.table[WATCHDOG] == 0xFF:
                return ACCESS
            goal = int.from_bytes(data, "little", signed=True)
            if self.table[OPERATING_MODE] == 3 and not self.get(MIN_LIMIT, 4) <= goal <= self.get(MAX_LIMIT, 4):
                return LIMIT
        self.table[address : address + len(data)] = data
        return 0


class Servos:
    """A bus of servos: what comes is parsed and done, and what they answer is returned."""

    def __init__(self, *servos: Servo) -> None:
        """Have these servos."""
        self.servos = {servo.number: servo for servo in servos}
        self.held = b""
        self.damage = 0
        """Number of status packets still to be damaged."""

    def __call__(self, data: bytes) -> bytes:
        """Return the answer to bytes; half a packet is kept."""
        self.held += data
        said = b""
        while (at := self.held.find(b"\xff\xff\xfd\x00")) >= 0 and len(self.held) >= at + 7:
            end = at + 7 + int.from_bytes(self.held[at + 5 : at + 7], "little")
            if len(self.held) < end:
                break
            packet, self.held = self.held[at:end], self.held[end:]
            if crc(packet[:-2]) == int.from_bytes(packet[-2:], "little"):
                body = packet[7:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
                said += self.answer(packet[4], body[0], body[1:])
        return said

    def answer(self, number: int, instruction: int, parameters: bytes) -> bytes:
        """Return what the servos say to an instruction."""
        for servo in self.servos.values():
            servo.advance()
        if instruction == SYNC_WRITE:
            address, length = (int.from_bytes(parameters[i : i + 2], "little") for i in (0, 2))
            for i in range(4, len(parameters), 1 + length):
                if servo := self.servos.get(parameters[i]):
                    servo.write(address, parameters[i + 1 : i + 1 + length])
            return b""
        if instruction == SYNC_READ:
            address, length = (int.from_bytes(parameters[i : i + 2], "little") for i in (0, 2))
            asked = (self.servos[one] for one in parameters[4:] if one in self.servos)
            return b"".join(self.status(servo, 0, bytes(servo.table[address : address + length])) for servo in asked)
        servo = self.servos.get(number)
        if servo is None:
            return b""
        if instruction == PING:
            return self.status(servo, 0, bytes(servo.table[0:2]) + bytes(servo.table[6:7]))
        if instruction == WRITE:
            return self.status(servo, servo.write(int.from_bytes(parameters[:2], "little"), parameters[2:]))
        if instruction == REBOOT:
            servo.table[HARDWARE_ERROR] = servo.table[TORQUE] = servo.table[WATCHDOG] = 0
            servo.started = time.monotonic()
            return self.status(servo, 0)
        return self.status(servo, INSTRUCTION)

    def status(self, servo: Servo, error: int, parameters: bytes = b"") -> bytes:
        """Return a status packet; none of a servo that is pulled off the bus."""
        if not servo.answers:
            return b""
        error |= 0x80 if servo.table[HARDWARE_ERROR] else 0
        body = bytes((STATUS, error)) + parameters
        body = body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        packet = b"\xff\xff\xfd\x00" + bytes((servo.number,)) + (len(body) + 2).to_bytes(2, "little") + body
        packet += crc(packet).to_bytes(2, "little")
        if self.damage:
            self.damage -= 1
            packet = packet[:-3] + bytes((packet[-3] ^ 0x10,)) + packet[-2:]
        return packet
