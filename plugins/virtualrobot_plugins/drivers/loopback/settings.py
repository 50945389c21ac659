"""Settings of the driver `loopback`, and the faults that it has on demand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

What = Literal[
    "silent",
    "raises",
    "raises_at_end",
    "hangs",
    "hangs_at_end",
    "dies",
    "floods",
    "nan",
    "protective_stop",
    "safeguard_stop",
    "emergency_stop",
    "power",
    "stuck",
    "displaced",
    "slow",
    "late",
    "hand_guided",
    "local",
]
"""Kinds of faults; docs/drivers/loopback.md says what each does."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that comes by itself, once in the life of the driver."""

    what: Annotated[What, Meta(description="Kind of the fault.")]
    cycle: Annotated[
        int,
        Meta(ge=0, description="Number of the controller's cycle, counted from the first `begin`, at which it comes."),
    ]
    joint: Annotated[int, Meta(ge=0, lt=64, description="Joint that it strikes, counted from 0.")] = 0
    value: Annotated[
        float | None,
        Meta(
            description="`displaced`: by how far (rad, m; 0.1); `slow`: share of the speed (0.5); `late`: by how much "
            "(s; 0.08, at most 10); `nan`, `power`, `silent`: number of cycles that it lasts (1, those of a second, "
            "for ever)."
        ),
    ] = None


@dataclass(frozen=True, slots=True)
class LoopbackSettings:
    """Settings of a computed controller; the defaults are those of an ideal one with six joints."""

    joints: Annotated[int, Meta(ge=1, le=64, description="Number of joints.")] = 6
    rate: Annotated[float, Meta(ge=1, le=1000, description="Cycles a second (Hz).")] = 125.0
    pace: Annotated[
        Literal["HOST", "CONTROLLER", "JOBS"],
        Meta(description="Who says when the next setpoint is due; JOBS: the controller plans by itself."),
    ] = "HOST"
    start: Annotated[
        tuple[float, ...], Meta(description="Where the joints stand at first (rad, m); zeros where it is left out.")
    ] = ()
    degrees: Annotated[bool, Meta(description="The controller speaks degrees.")] = False
    speed: Annotated[float, Meta(gt=0, description="Greatest speed of each joint (rad/s, m/s).")] = 3.0
    acceleration: Annotated[
        float, Meta(gt=0, description="Acceleration by which a joint stops, and by which jobs go (rad/s2, m/s2).")
    ] = 10.0
    delay: Annotated[float, Meta(ge=0, le=1, description="Time from a setpoint to what it does (s).")] = 0.0
    jitter: Annotated[
        float, Meta(ge=0, le=1, description="Greatest time that a setpoint is later than that, by chance (s).")
    ] = 0.0
    loss: Annotated[float, Meta(ge=0, lt=1, description="Share of setpoints that are lost, by chance.")] = 0.0
    lag: Annotated[
        float,
        Meta(ge=0, le=10, description="Time constant by which joints follow setpoints (s): the following error."),
    ] = 0.0
    noise: Annotated[
        float, Meta(ge=0, le=1, description="Standard deviation of the positions that are read (rad, m).")
    ] = 0.0
    seed: Annotated[int, Meta(ge=0, description="Seed of all that is by chance.")] = 0
    watchdog: Annotated[
        float,
        Meta(
            ge=0, le=60, description="Time without a setpoint, of JOBS a reading (s), until the robot stops; 0: never."
        ),
    ] = 0.1
    faults: Annotated[tuple[Fault, ...], Meta(description="Faults that come by themselves.")] = ()
    control_port: Annotated[
        int, Meta(ge=0, le=65535, description="UDP port on 127.0.0.1 for faults on demand; 0: none.")
    ] = 0

    def __post_init__(self) -> None:
        """Refuse what does not fit together."""
        if self.start and len(self.start) != self.joints:
            raise ValueError(f"start has {len(self.start)} values; there are {self.joints} joints")
        for fault in self.faults:
            if fault.joint >= self.joints:
                raise ValueError(f"a fault strikes joint {fault.joint}; there are {self.joints}, counted from 0")
            if fault.what == "slow" and not 0.0 <= (0.5 if fault.value is None else fault.value) <= 1.0:
                raise ValueError(f"the value of 'slow' is {fault.value}; it must be a share, 0 to 1")
