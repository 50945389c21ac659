"""SensorService: sensors at work."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from virtualrobot.v1 import sensor_pb2, sensor_pb2_grpc

from virtualrobot_kernel.api.convert.presets import PRESET
from virtualrobot_kernel.api.convert.readings import STATES, checked_options, content_bytes, fill_reading, is_large
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.message_parts import parts
from virtualrobot_kernel.api.publications import pause_seconds
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.sensing.range_reader import RangeReader
from virtualrobot_kernel.sensing.reading import Moment, Reading, SensorState
from virtualrobot_kernel.sensing.sensor_status import Status, statuses
from virtualrobot_kernel.world.apply_sensors import sensor_node, with_components
from virtualrobot_kernel.world.commands import SetRangeComponents
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.structure import Kind

FASTEST_HERTZ = 10_000.0

SENSOR_KINDS = {
    kind: getattr(sensor_pb2, f"SENSOR_KIND_{kind.name.removesuffix('_SENSOR')}")
    for kind in (Kind.RANGE_SENSOR, Kind.CAMERA_SENSOR, Kind.CONTACT_SENSOR, Kind.MOTION_SENSOR)
}

STATUS = Table(Status, sensor_pb2.SensorStatus, state=STATES, without=("node", "name", "kind"))


class _News(NamedTuple):
    """A reading that is told to somebody, and how many of its sensor before it were lost to him."""

    reading: Reading
    lost: int = 0


class SensorServicer(sensor_pb2_grpc.SensorServiceServicer):
    """Servicer of SensorService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def ListSensors(
        self, request: sensor_pb2.ListSensorsRequest, context: object
    ) -> sensor_pb2.ListSensorsResponse:
        """Tell how all sensors are."""
        snapshot = self._kernel.world.snapshot
        told = [
            STATUS.write(status, name=status.node.name, kind=SENSOR_KINDS[status.node.kind])
            for status in statuses(self._kernel.sensors, snapshot)
        ]
        return sensor_pb2.ListSensorsResponse(stamp=stamp(snapshot), sensors=told)

    async def ReadSensor(self, request: sensor_pb2.ReadSensorRequest, context: object) -> sensor_pb2.ReadSensorResponse:
        """Make one reading, in the sensor's own thread."""
        kinds = checked_options(request.options)
        worker, coming = self._kernel.sensors.read(request.sensor, kinds)
        waited = asyncio.wrap_future(coming)
        try:
            # What waits for its turn behind others is not late.
            while not (await asyncio.wait({waited}, timeout=worker.patience_seconds))[0]:
                if worker.reader is None or worker.ended or worker.is_late():
                    worker.give_up(f"a reading was not made within {worker.patience_seconds:g} s")
                    raise KernelError(
                        f"the sensor {request.sensor!r} cannot read: {worker.fault or 'it was changed meanwhile'}",
                        reason=Reason.PLUGIN_FAILED,
                        sensor=request.sensor,
                    )
            reading = waited.result()
        finally:
            waited.cancel()
        if is_large(reading):
            return await self._kernel.in_worker(_answer, reading, request.options)
        return _answer(reading, request.options)

    async def told(self, reading: Reading, options: sensor_pb2.ReadingOptions) -> sensor_pb2.SensorReading:
        """Return a reading that was made as a message."""
        checked_options(options)
        if is_large(reading):
            return await self._kernel.in_worker(_message, _News(reading), options)
        return _message(_News(reading), options)

    async def WatchReadings(
        self, request: sensor_pb2.WatchReadingsRequest, context: object
    ) -> AsyncIterator[sensor_pb2.WatchReadingsResponse]:
        """Tell the latest readings, then new ones; a slow reader gets the latest."""
        checked_options(request.options)
        pause = pause_seconds(request.max_rate_hertz, FASTEST_HERTZ)
        structure = self._kernel.world.snapshot.structure
        wanted = frozenset(sensor_node(structure, name).uid for name in request.sensors)
        if request.run and not wanted:
            raise KernelError("a watch that has sensors read names them", field="sensors")
        news = self._every_reading(wanted) if request.every_reading else self._latest_readings(wanted)
        end = None
        try:
            if request.run:
                begun, end = self._kernel.sensors.run_for(wanted)
                await asyncio.wrap_future(begun)
            if request.run or request.every_reading:
                yield sensor_pb2.WatchReadingsResponse()
            async for fresh in news:
                small = [one for one in fresh if not is_large(one.reading)]
                for message in _messages(small, request.options):
                    yield message
                for one in fresh:
                    if is_large(one.reading):
                        yield await self._kernel.in_worker(_watched, one, request.options)
                if pause > 1.0 / FASTEST_HERTZ:
                    await self._kernel.publications.pause(pause)
        finally:
            await news.aclose()
            if end is not None:
                end()

    async def _latest_readings(self, wanted: frozenset[int]) -> AsyncGenerator[list[_News], None]:
        """Yield the latest readings of sensors (uids; none: all), then the latest of those that have newer ones."""
        sensors = self._kernel.sensors
        told: dict[int, Reading] = {}
        async for _ in self._kernel.publications.each(sensors.subscribe):
            latest = {uid: one for uid, one in sensors.latest.items() if not wanted or uid in wanted}
            gone = [uid for uid in told if uid not in latest]
            fresh = [one for uid, one in latest.items() if told.get(uid) is not one]
            fresh += [_removed(told.pop(uid)) for uid in gone]
            told |= latest
            yield list(map(_News, fresh))

    async def _every_reading(self, wanted: frozenset[int]) -> AsyncGenerator[list[_News], None]:
        """Yield the latest readings of sensors (uids; none: all), then each new one, none left out."""
        sensors = self._kernel.sensors
        told: dict[int, Reading] = {}
        news = self._kernel.publications.every_one(sensors.subscribe, content_bytes)
        try:
            await anext(news)
            begun = {uid: one for uid, one in sensors.latest.items() if not wanted or uid in wanted}
            told |= begun
            yield list(map(_News, begun.values()))
            async for came in news:
                fresh: list[_News] = []
                for one in came:
                    if one is None:
                        gone = [uid for uid in told if uid not in sensors.latest]
                        fresh += [_News(_removed(told.pop(uid))) for uid in gone]
                    elif not wanted or one.uid in wanted:
                        before = told.get(one.uid)
                        if before is not None and before is begun.get(one.uid) and not _is_newer(one, before):
                            continue  # it came between listening and looking
                        fresh.append(_News(one, _lost(before, one)))
                        told[one.uid] = one
                yield fresh
        finally:
            await news.aclose()

    async def SetRangeComponents(
        self, request: sensor_pb2.SetRangeComponentsRequest, context: object
    ) -> sensor_pb2.SetRangeComponentsResponse:
        """Try other components on the sensor, then give them to it."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(request.sensor, Kind.RANGE_SENSOR)
        command = SetRangeComponents(
            request.sensor,
            (request.ray_caster, settings(request.ray_caster_settings, "ray_caster_settings"))
            if request.HasField("ray_caster")
            else None,
            (request.sensor_model, settings(request.sensor_model_settings, "sensor_model_settings"))
            if request.HasField("sensor_model")
            else None,
        )
        assert isinstance(node.data, RangeSensor)
        changed = replace(node, data=with_components(node.data, command))

        def tried() -> RangeReader:
            room = self._kernel.sensing
            reader = RangeReader(changed, room.catalog, room.shapes, room.presets)
            try:
                reader.read(Moment(snapshot, (), 1, np.random.default_rng((changed.data.seed, 1))))  # pyright: ignore[reportOptionalMemberAccess, reportAttributeAccessIssue] a range sensor's
            finally:
                reader.close()
            return reader

        reader = await self._kernel.limiter.run([node.uid], tried)
        applied = await asyncio.wrap_future(self._kernel.submit([command], context))
        return sensor_pb2.SetRangeComponentsResponse(
            stamp=stamp(applied.snapshot),
            cast_seconds=reader.cast_seconds,
            model_seconds=reader.model_seconds,
            rays=reader.ray_count,
        )

    async def ListSensorPresets(
        self, request: sensor_pb2.ListSensorPresetsRequest, context: object
    ) -> sensor_pb2.ListSensorPresetsResponse:
        """Tell the devices that a range sensor may be set as."""
        presets = sorted(self._kernel.sensing.presets.values(), key=lambda one: one.name)
        return sensor_pb2.ListSensorPresetsResponse(presets=map(PRESET.write, presets))


def _removed(last: Reading) -> Reading:
    """Return the last reading of a sensor as stopped, with the fault that it is gone."""
    fault = f"the sensor {last.name!r} was removed from the world"
    return replace(last, state=SensorState.STOPPED, fault=fault, content=None)


def _is_newer(one: Reading, before: Reading) -> bool:
    """Return whether a reading was told after another one; numbers don't say it, as they begin anew with each start."""
    at, then = ((told.snapshot.revision, told.snapshot.state.tick) for told in (one, before))
    return at > then or (at == then and one is not before and one.content is None)  # what has stopped since


def _lost(before: Reading | None, one: Reading) -> int:
    """Return how many readings a sensor has made between two that are told one after the other."""
    if before is None or before.content is None or one.content is None:
        return 0
    return max(one.number - before.number - 1, 0)


def _messages(news: list[_News], options: sensor_pb2.ReadingOptions) -> Iterator[sensor_pb2.WatchReadingsResponse]:
    """Yield small readings, many together."""
    for part in parts(_message(one, options) for one in news):
        yield sensor_pb2.WatchReadingsResponse(readings=part)


def _message(news: _News, options: sensor_pb2.ReadingOptions) -> sensor_pb2.SensorReading:
    message = sensor_pb2.SensorReading(lost=news.lost)
    fill_reading(message, news.reading, options)
    return message


def _watched(news: _News, options: sensor_pb2.ReadingOptions) -> sensor_pb2.WatchReadingsResponse:
    return sensor_pb2.WatchReadingsResponse(readings=[_message(news, options)])


def _answer(reading: Reading, options: sensor_pb2.ReadingOptions) -> sensor_pb2.ReadSensorResponse:
    response = sensor_pb2.ReadSensorResponse()
    fill_reading(response.reading, reading, options)
    return response
