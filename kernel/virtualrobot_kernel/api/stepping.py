"""Steps of the clock with all that goes with one: what is set before it, what ends it, and what is read after it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from virtualrobot.v1 import kernel_pb2, motion_pb2, scene_pb2, sensor_pb2

from virtualrobot_kernel.api.convert.states import motion_message, robot_states, robots_named
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.scene import SceneServicer
from virtualrobot_kernel.api.sensor import SensorServicer
from virtualrobot_kernel.api.step_setpoints import StepSetpoints
from virtualrobot_kernel.collision.node_pairs import movers
from virtualrobot_kernel.collision.transitions import watched
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.messages.signals import condition_of, signal_message
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.world.apply_sensors import sensor_node
from virtualrobot_kernel.world.apply_signals import check_condition
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Event = Callable[[Snapshot], bool]
"""Event as a question about the world after a tick; asked in the world thread."""


class Stepping:
    """Steps of the clock by clients' calls."""

    def __init__(self, kernel: KernelServices) -> None:
        """Step the world of a kernel."""
        self._kernel = kernel
        self._scene, self._sensor = SceneServicer(kernel), SensorServicer(kernel)
        self._setpoints = StepSetpoints(kernel)

    async def step(self, request: kernel_pb2.StepClockRequest, context: object) -> kernel_pb2.StepClockResponse:
        """Make a step; raise KernelError for what is refused, before anything is changed."""
        world = self._kernel.world
        if request.commands or request.setpoints or request.until or request.sensors:
            self._check(request)
        events = [self._event(event, f"until[{place}]") for place, event in enumerate(request.until)]
        ids: Sequence[str] = ()
        if request.setpoints:
            async with self._setpoints.given(request.setpoints, context) as ids:
                await self._apply(request, context)
        else:
            await self._apply(request, context)
        before = world.snapshot.state.tick
        met: list[int] = []

        def until(snapshot: Snapshot) -> bool:
            met[:] = [place for place, event in enumerate(events) if event(snapshot)]
            return bool(met)

        snapshot = await asyncio.wrap_future(world.step(request.ticks, until if events else None))
        state = snapshot.state
        ended = [motion for motion in state.ended if motion.end_tick > before]
        return kernel_pb2.StepClockResponse(
            stamp=stamp(snapshot),
            robots=robot_states(snapshot, robots_named(snapshot, ()), self._kernel.forces.exerted),
            signals=[signal_message(snapshot.structure, signal) for signal in state.signals.values()],
            motions=[motion_message(snapshot, motion) for motion in (*ended, *state.motions)],
            readings=[await self._read(name, request, context) for name in request.sensors],
            ticks=state.tick - before,
            events=met,
            setpoint_motion_ids=ids,
        )

    def end_setpoints(self, context: object) -> None:
        """Have the motions stop that follow setpoints of the steps of a client that steps no more."""
        self._setpoints.end(context)

    def _check(self, request: kernel_pb2.StepClockRequest) -> None:
        """Raise KernelError for a step that cannot be made, before what goes with it is done."""
        self._kernel.world.check_step(request.ticks)
        for name in request.sensors:
            sensor_node(self._kernel.world.snapshot.structure, name)

    async def _apply(self, request: kernel_pb2.StepClockRequest, context: object) -> None:
        if request.commands:
            await self._scene.Apply(scene_pb2.ApplyRequest(commands=request.commands), context)

    async def _read(self, name: str, request: kernel_pb2.StepClockRequest, context: object) -> sensor_pb2.SensorReading:
        """Return the latest reading of a sensor at work, or one made now."""
        latest = self._latest(name)
        if latest is not None:
            return await self._sensor.told(latest, request.reading_options)
        asked = sensor_pb2.ReadSensorRequest(sensor=name, options=request.reading_options)
        return (await self._sensor.ReadSensor(asked, context)).reading

    def _latest(self, name: str) -> Reading | None:
        sensors, structure = self._kernel.sensors, self._kernel.world.snapshot.structure
        uid = structure.uid_by_name.get(name, 0)
        latest = sensors.latest.get(uid)
        return latest if uid in sensors.starts and latest is not None and latest.content is not None else None

    def _event(self, event: kernel_pb2.StepEvent, field: str) -> Event:
        """Return the question that an event is; raise KernelError for what is not there, or can never be."""
        kind = event.WhichOneof("event")
        ask = {
            "motion_ended": self._motion_ended,
            "signal": self._signal,
            "collision_of": self._collision,
            "reading_of": self._reading,
        }.get(kind or "")
        if ask is None:
            raise KernelError(f"{field} says no event", field=field)
        return ask(getattr(event, str(kind)), f"{field}.{kind}")

    def _motion_ended(self, id: str, field: str) -> Event:
        state = self._kernel.world.snapshot.state
        known = [motion.id for motion in (*state.motions, *state.ended)]
        if id not in known:
            raise UnknownNameError("motion", id, known)
        return lambda snapshot: all(motion.id != id for motion in snapshot.state.motions)

    def _signal(self, message: motion_pb2.SignalCondition, field: str) -> Event:
        condition = condition_of(message, field)
        check_condition(self._kernel.world.snapshot.state, condition)

        def holds(snapshot: Snapshot) -> bool:
            signal = snapshot.state.signals.get(condition.signal)
            return condition.holds(signal.value if signal is not None else None)

        return holds

    def _collision(self, robot: str, field: str) -> Event:
        snapshot = self._kernel.world.snapshot
        uid = snapshot.structure.node(robot, Kind.ROBOT).uid
        if uid not in watched(snapshot):
            raise KernelError(
                f"{field}: the collisions of {robot!r} are not monitored, so that none is ever told",
                reason=Reason.WRONG_STATE,
                field=field,
                robot=robot,
            )
        monitor = self._kernel.monitor

        def touches(snapshot: Snapshot) -> bool:
            nodes = snapshot.structure.nodes
            pairs = [(one.pair.first, one.pair.second) for one in monitor.latest.touching if not one.tolerated]
            return any(
                uid in movers(pair, snapshot.structure) for pair in pairs if pair[0] in nodes and pair[1] in nodes
            )

        return touches

    def _reading(self, name: str, field: str) -> Event:
        sensors = self._kernel.sensors
        uid = sensor_node(self._kernel.world.snapshot.structure, name).uid
        if uid not in sensors.starts:
            raise KernelError(
                f"{field}: {name!r} does not read; start it, or watch it with `run`",
                reason=Reason.WRONG_STATE,
                field=field,
                sensor=name,
            )
        before = sensors.latest.get(uid)
        return lambda _: sensors.latest.get(uid) is not before
