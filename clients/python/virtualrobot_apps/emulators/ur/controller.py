"""State of an emulated controller, and what it does in one cycle; nothing here knows of sockets or of time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from enum import IntEnum
from typing import Any, Protocol

import numpy as np

from virtualrobot_apps.emulators.body import Body
from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.compliance import Compliance
from virtualrobot_apps.emulators.ur.forces import Forces, Payload, Unmeasured
from virtualrobot_apps.emulators.ur.kinematics import MODELS, Floats
from virtualrobot_apps.emulators.ur.moves import PLANNED, Move, Servo, Stop
from virtualrobot_apps.emulators.ur.touches import Touches

STARTING_CYCLES = 50
"""Cycles in which power comes on, and in which brakes open."""
END_DECELERATION = 4.0
"""Deceleration (rad/s^2) with which joints stop as a program ends."""
HARD_DECELERATION = 12.0
"""That of a protective stop."""
PAUSE_SECONDS = 0.25
"""Time (s) in which a move that is paused comes to rest, and in which it is as fast as before."""
SETTLED = 1e-5
"""Distance (rad) of the arm from a setpoint that doesn't move at which it is left to itself."""
_LOGGED = 1000
"""Lines of the log of one cycle that are kept."""
REMEMBERED = 1000
"""Cycles that the arm's past is known for."""
SETTLE_CYCLES = 500
"""Cycles after which an arm that doesn't get there is left to itself, too."""


class RobotMode(IntEnum):
    """State of the arm's power and brakes, as RTDE numbers it."""

    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    BACKDRIVE = 6
    RUNNING = 7


class SafetyMode(IntEnum):
    """Verdict of the safety system, as RTDE numbers it."""

    NORMAL = 1
    REDUCED = 2
    PROTECTIVE_STOP = 3
    RECOVERY = 4
    SAFEGUARD_STOP = 5
    SYSTEM_EMERGENCY_STOP = 6
    ROBOT_EMERGENCY_STOP = 7
    VIOLATION = 8
    FAULT = 9


class Runtime(IntEnum):
    """State of the program."""

    STOPPED = 1
    PLAYING = 2
    PAUSED = 4


class Program(Protocol):
    """A script that runs."""

    name: str

    def cycle(self, controller: Controller) -> bool:
        """Do what the script does in one cycle; return whether it goes on."""
        ...

    def close(self) -> None:
        """Give back what it has: it is over."""
        ...


class Watchdog:
    """rtde_set_watchdog: the program is stopped or paused where an input isn't written often enough."""

    def __init__(self, variable: str, cycles: int, pauses: bool) -> None:
        """Watch an input, which may be silent for `cycles`."""
        self.variable, self.cycles, self.pauses, self.silent = variable, cycles, pauses, 0


class Controller:
    """A controller, its arm and its program."""

    def __init__(
        self,
        body: Body,
        model: str = "ur5e",
        version: tuple[int, int, int, int] = (5, 26, 0, 0),
        serial: str = "20195500001",
        rate: float = 500.0,
    ) -> None:
        """Have power, brakes open; raises ValueError for a model or an arm that is none of Universal Robots'."""
        if model not in MODELS:
            raise ValueError(f"there is no model {model!r}; there are {', '.join(MODELS)}")
        if len(body.joint_names) != 6 or any(body.sliding):
            raise ValueError(f"arms of Universal Robots have six joints that turn, not {len(body.joint_names)}")
        self.body, self.model, self.version, self.serial, self.rate = body, MODELS[model], version, serial, rate
        self.mode, self.safety = RobotMode.RUNNING, SafetyMode.NORMAL
        self.remote = True
        self.cycles = 0
        self.inputs: dict[str, object] = {}
        self.registers: dict[str, object] = {}
        self.digital_inputs = self.digital_outputs = self.flags = 0
        self.analog_inputs, self.analog_shares = [0.0, 0.0], [0.0, 0.0]
        """Volts of inputs, and shares from 0 to 1 of what outputs give at most."""
        self.tool: dict[str, float] = {}
        """Settings of the tool that scripts have made, by their names in RTDE."""
        self.voltages = 0b1111
        """Analog inputs (bits 0, 1) and outputs (2, 3) that are voltages; others are currents."""
        self.slider = 1.0
        self.tcp, self.mass = np.eye(4), 0.0
        self.center: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.inertia: tuple[float, ...] = (0.0,) * 6
        self.program: Program | None = None
        self.paused = False
        """The program stands where it is, and so does the move that it makes."""
        self.touches: Touches | None = None
        """Touches of the robot in a kernel, which tool_contact tells."""
        self.forces = Forces()
        self.compliance: Compliance | None = None
        """Force mode, where it is on."""
        self.attended = self.popup = False
        """Somebody is there who can close a popup; one is open for which a script waits."""
        self.begun: Callable[[Any], None] = lambda program: None
        """Is told each script of a client as it begins."""
        self.off = False
        """It was shut down, and answers nobody any more."""
        self.watchdog: Watchdog | None = None
        self.move: Move | None = None
        self.target, self.velocity = body.read()
        self.acceleration = np.zeros(6)
        self.past: deque[Floats] = deque([self.target], REMEMBERED)
        """Positions (6,) of the arm after each cycle, the newest last."""
        self.words: list[tuple[int, int, str]] = []
        """Messages that haven't gone out yet: number of the error, its argument, words."""
        self.logged: list[str] = []
        """Lines of the log that haven't gone out yet, the last ones."""
        self._pace = 1.0
        self._follows = False
        self._settling = 0
        self._until = 0

    @property
    def dt(self) -> float:
        """Duration of a cycle (s)."""
        return 1.0 / self.rate

    @property
    def stopped(self) -> bool:
        """The safety system keeps the arm from moving."""
        return self.safety not in (SafetyMode.NORMAL, SafetyMode.REDUCED)

    @property
    def playing(self) -> bool:
        """A program runs, and isn't paused."""
        return self.program is not None and not self.paused

    @property
    def moving(self) -> bool:
        """The arm is on its way, or hasn't quite arrived."""
        return self.move is not None or (self._follows and self.compliance is None)

    @property
    def payload(self) -> Payload:
        """Mass on the flange, as scripts have set it."""
        return Payload(self.mass, np.array(self.center))

    @property
    def base_t_flange(self) -> Floats:
        """Pose (4, 4) of the flange."""
        return kinematics.forward(self.model, self.body.read()[0])

    def cycle(self) -> None:
        """Do what a cycle does."""
        self.cycles += 1
        if self._until and self.cycles >= self._until:
            self._until = 0
            self.mode = RobotMode.IDLE if self.mode is RobotMode.POWER_ON else RobotMode.RUNNING
        if self.body.complaint and not self.stopped:
            self.protective_stop(self.body.complaint)
        if self.watchdog is not None and not (self.watchdog.pauses and self.paused):
            self._watch(self.watchdog)
        if self.program is not None and not self.paused and not self.program.cycle(self):
            self.end_program()
        before = self.velocity
        self._advance()
        self.acceleration = (self.velocity - before) / self.dt
        self.body.advance(self.dt)
        self.past.append(self.body.read()[0])
        if self.touches is not None:
            self.touches.cycle()

    def _watch(self, watchdog: Watchdog) -> None:
        watchdog.silent += 1
        if watchdog.silent > watchdog.cycles:
            if watchdog.pauses:
                self.pause()
            else:
                self.end_program()
            done = "paused" if watchdog.pauses else "stopped"
            self.say(207, 0, f"RTDE watchdog: {watchdog.variable} was not written in time, the program is {done}")

    def _advance(self) -> None:
        change = self.dt / PAUSE_SECONDS
        self._pace = max(0.0, self._pace - change) if self.paused else min(1.0, self._pace + change)
        if self.compliance is not None and self.compliance.resting and self.move is not self.compliance.move:
            self.compliance = None
        gives_way = self.compliance is not None and self._pace > 0.0
        if (self.move is not None or gives_way) and self.mode is RobotMode.RUNNING:
            try:
                goal = self._setpoint()
            except kinematics.NoPosture as error:
                self.move = None
                self.protective_stop(str(error))
                return
            except Unmeasured as error:
                self.end_program()
                self.say(255, 0, f"the force mode ends: {error}")
                return
            self.velocity = (goal - self.target) / self.dt
            self.target = goal
            if self.move is not None and self.move.over:
                self.move, self.velocity = None, self.velocity if gives_way else np.zeros(6)
            self.body.follow(self.target)
            self._follows, self._settling = True, 0
            return
        self.velocity = np.zeros(6)
        if self._follows:
            self._settling += 1
            here, _ = self.body.read()
            if np.abs(here - self.target).max() < SETTLED or self._settling > SETTLE_CYCLES:
                self.body.halt()
                self._follows = False
            else:
                self.body.follow(self.target)

    def _setpoint(self) -> Floats:
        """Return the next setpoint (6,)."""
        mode = self.compliance
        if mode is None:
            return self._planned(self.target, self.velocity)
        if mode.move is not self.move:
            mode.follow(self.move, self.target, self.velocity)
        goal = self._planned(mode.planned, mode.planned_velocity)
        felt = np.zeros(6) if mode.resting else self.felt()
        return mode.advance(self.model, self.tcp, self.target, goal, felt, self.body.read()[0], self._pace)

    def _planned(self, here: Floats, velocity: Floats) -> Floats:
        """Return the next setpoint (6,) that the move would have, where it is `here` (6,) at a `velocity` (6,)."""
        if self.move is None:
            return here
        # Slider and pause slow moves that the controller plans; setpoints and stops have their own time.
        seconds = self.dt * (self.slider * self._pace if isinstance(self.move, PLANNED) else 1.0)
        return self.move.advance(here, velocity, seconds)

    def felt(self) -> Floats:
        """Return force and torque (6,) on the tool about the TCP, along the base's axes. Raises Unmeasured."""
        return self.forces.on_tool(self.base_t_flange, self.tcp, self.payload)

    def give_way(self) -> Compliance:
        """Return the force mode, which begins unless it is on."""
        if self.compliance is None:
            self.compliance = Compliance(self.move, self.begin(), self.velocity, self.rate)
        return self.compliance

    def go(self, move: Callable[[Floats], Move]) -> None:
        """Begin a move, made from where the setpoint is; its own controller's programs alone call it."""
        try:
            self.move = move(self.begin())
        except kinematics.NoPosture as error:
            self.end_program()
            self.say(255, 0, str(error))

    def begin(self) -> Floats:
        """Return where the setpoint (6,) is, from which a move begins: where the arm is, unless it follows one."""
        if not self._follows:
            self.target, self.velocity = self.body.read()[0], np.zeros(6)
        return self.target

    def halt(self, deceleration: float | None = None) -> None:
        """Slow down to rest, at a deceleration of the fastest joint (rad/s^2); without one a stop at work goes on."""
        if isinstance(self.move, Servo):
            # Setpoints come by steps: what the arm does is smoother.
            self.target, self.velocity = self.body.read()
        moves = self.move is not None or self.velocity.any()  # force mode moves the arm without a move
        if moves and (deceleration is not None or not isinstance(self.move, Stop)):
            self.move = Stop(END_DECELERATION if deceleration is None else deceleration)

    def say(self, code: int, argument: int, text: str) -> None:
        """Have words for whoever listens."""
        self.words.append((code, argument, text))

    def log(self, text: str) -> None:
        """Have words of a script for its log, which clients of the primary interface are told."""
        self.logged.append(text)
        del self.logged[:-_LOGGED]

    def play(self, program: Program) -> str:
        """Run a program in place of the one that runs; return why it can't, empty where it does."""
        if not self.remote:
            return "the robot is in local control"
        if self.mode is not RobotMode.RUNNING or self.stopped:
            return f"the robot is {self.mode.name}, safety {self.safety.name}"
        self.end_program()
        self.program = program
        return ""

    def end_program(self) -> None:
        """End the program; what moves slows down."""
        if self.program is not None:
            program, self.program, self.watchdog = self.program, None, None
            self.paused, self.popup, self._pace, self.compliance = False, False, 1.0, None
            program.close()
            self.halt()

    def pause(self) -> bool:
        """Pause the program, whose move comes to rest on its path; return False where none runs."""
        if self.program is None:
            return False
        self.paused = True
        if not isinstance(self.move, PLANNED):
            self.halt()  # setpoints and velocities are the program's own
        return True

    def go_on(self) -> bool:
        """Have the program that was paused go on; return False where there is none, or the robot can't move."""
        if not self.paused or self.mode is not RobotMode.RUNNING:
            return False
        self.paused = False
        if self.watchdog is not None:
            self.watchdog.silent = 0
        return True

    def shut_down(self) -> None:
        """Take the arm's power, and be off."""
        self.power_off()
        self.off = True

    def watch(self, variable: str, cycles: int, pauses: bool = False) -> None:
        """Stop the program, or pause it, where an input isn't written for so many cycles; 0: watch nothing."""
        self.watchdog = Watchdog(variable, cycles, pauses) if cycles else None

    def take(self, values: Mapping[str, object]) -> None:
        """Take inputs that a client has set."""
        self.inputs.update(values)
        self.forces.told = np.array(self.inputs.get("external_force_torque", self.forces.told), dtype=np.float64)
        if self.watchdog is not None and self.watchdog.variable in values:
            self.watchdog.silent = 0
        for name, shift in (("standard", 0), ("configurable", 8), ("tool", 16)):
            mask = values.get(f"{name}_digital_output_mask")
            if isinstance(mask, int) and mask:
                self.set_outputs(mask << shift, int(self.inputs.get(f"{name}_digital_output", 0)) << shift)  # type: ignore[call-overload]
        mask = values.get("standard_analog_output_mask")
        for number in range(2):
            if isinstance(mask, int) and mask >> number & 1:
                share = float(np.clip(float(self.inputs.get(f"standard_analog_output_{number}", 0.0)), 0.0, 1.0))  # type: ignore[arg-type]
                voltage = int(self.inputs.get("standard_analog_output_type", 0)) >> number & 1  # type: ignore[call-overload]
                self.set_output_domain(number, voltage == 1)
                self.analog_shares[number] = share
        if values.get("speed_slider_mask"):
            self.slider = float(np.clip(float(self.inputs.get("speed_slider_fraction", 1.0)), 0.0, 1.0))  # type: ignore[arg-type]

    def set_outputs(self, mask: int, values: int) -> None:
        """Set the digital outputs of a mask."""
        self.digital_outputs = self.digital_outputs & ~mask | values & mask

    def protective_stop(self, text: str, code: int = 153, argument: int = 0) -> None:
        """Stop as after a collision."""
        self._safety_stop(SafetyMode.PROTECTIVE_STOP, code, argument, text)

    def safeguard_stop(self) -> None:
        """Stop as by an open door."""
        self._safety_stop(SafetyMode.SAFEGUARD_STOP, 0, 0, "Safeguard stop")

    def emergency_stop(self) -> None:
        """Stop as by the button of the pendant; its power goes."""
        self._safety_stop(SafetyMode.ROBOT_EMERGENCY_STOP, 0, 0, "Emergency stop")

    def _safety_stop(self, safety: SafetyMode, code: int, argument: int, text: str) -> None:
        self.safety = safety
        self.end_program()
        if self.move is not None:
            self.move = Stop(HARD_DECELERATION)
        self.say(code, argument, text)

    def release(self) -> None:
        """Leave a stop of the safety system; after an emergency stop power has to be switched on again."""
        if self.safety is SafetyMode.ROBOT_EMERGENCY_STOP:
            self.power_off()
        self.body.recover()
        self.safety = SafetyMode.NORMAL

    def power_off(self) -> None:
        """Take the arm's power; brakes close."""
        self.end_program()
        self.move, self.mode, self._until, self._follows = None, RobotMode.POWER_OFF, 0, False
        self.body.halt()

    def power_on(self) -> None:
        """Give the arm power; it is idle soon."""
        if self.mode is RobotMode.POWER_OFF:
            self.mode, self._until = RobotMode.POWER_ON, self.cycles + STARTING_CYCLES

    def release_brakes(self) -> None:
        """Open the brakes; the arm is running soon."""
        if self.mode in (RobotMode.POWER_OFF, RobotMode.POWER_ON):
            self.mode = RobotMode.IDLE
        if self.mode is RobotMode.IDLE:
            self._until = self.cycles + STARTING_CYCLES

    def set_output_domain(self, number: int, voltage: bool) -> None:
        """Make an analog output, 0 or 1, a voltage or a current; its share is as it was."""
        self.voltages = self.voltages & ~(4 << number) | voltage << 2 + number

    def _analog_output(self, number: int) -> float:
        """Return the level of an analog output, in volts or amperes."""
        share = self.analog_shares[number]
        return 10.0 * share if self.voltages >> 2 + number & 1 else 0.004 + 0.016 * share

    def tell(self) -> dict[str, object]:
        """Return what RTDE tells in this cycle, by name; what is missing is 0."""
        positions, velocities = self.body.read()
        model, running = self.model, self.mode is RobotMode.RUNNING
        flange = kinematics.forward(model, positions)
        actual = kinematics.pose_of(flange @ self.tcp)
        target = kinematics.pose_of(kinematics.forward(model, self.target, self.tcp))
        runs = self.playing
        felt = raw = np.zeros(6)
        with suppress(Unmeasured):
            raw, _ = self.forces.measured(flange)
            felt = self.forces.on_tool(flange, self.tcp, self.payload)
        safety = {SafetyMode.NORMAL: 1, SafetyMode.REDUCED: 2, SafetyMode.PROTECTIVE_STOP: 4}.get(self.safety, 0)
        safety |= {SafetyMode.SAFEGUARD_STOP: 16, SafetyMode.ROBOT_EMERGENCY_STOP: 64 | 128}.get(self.safety, 0)
        return {
            "timestamp": self.cycles * self.dt,
            "actual_q": positions,
            "actual_qd": velocities,
            "target_q": self.target if self._follows else positions,
            "target_qd": self.velocity,
            "target_qdd": self.acceleration,
            "actual_TCP_pose": actual,
            "target_TCP_pose": target if self._follows else actual,
            "actual_TCP_speed": kinematics.jacobian(model, positions, self.tcp) @ velocities,
            "actual_TCP_force": felt,
            "ft_raw_wrench": raw,
            "tcp_force_scalar": float(np.linalg.norm(felt[:3])),
            "tcp_offset": kinematics.pose_of(self.tcp),
            "joint_mode": 253 if running else 239,
            "robot_mode": int(self.mode),
            "safety_mode": int(self.safety),
            "safety_status": int(self.safety),
            "safety_status_bits": safety | (1024 if self.stopped else 0),
            "robot_status_bits": (1 if self.mode > RobotMode.POWER_OFF else 0) | (2 if runs else 0),
            "runtime_state": int(Runtime.PAUSED if self.paused else Runtime.PLAYING if runs else Runtime.STOPPED),
            "speed_scaling": self.slider if runs else 0.0,
            "target_speed_fraction": self.slider,
            "actual_digital_input_bits": self.digital_inputs,
            "actual_digital_output_bits": self.digital_outputs,
            "standard_analog_input0": self.analog_inputs[0],
            "standard_analog_input1": self.analog_inputs[1],
            "standard_analog_output0": self._analog_output(0),
            "standard_analog_output1": self._analog_output(1),
            "analog_io_types": self.voltages,
            "payload": self.mass,
            "payload_cog": self.center,
            "payload_inertia": self.inertia,
            **self.tool,
            **self.inputs,
            **self.registers,
        }
