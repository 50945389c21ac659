"""Reports of the collision monitor as messages."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot.v1 import collision_pb2

from virtualrobot_kernel.api.convert.collisions import pair_message
from virtualrobot_kernel.collision.guard import GuardCost
from virtualrobot_kernel.collision.report import Ended, Event, Report, Stopped, Touch
from virtualrobot_kernel.messages.values import stamp


def report_message(report: Report, told: int | None) -> collision_pb2.WatchCollisionsResponse:
    """Return a report with the events after the number `told`; None: the first one, which tells all that touches."""
    events, missed = ((), 0) if told is None else report.after(told)
    return collision_pb2.WatchCollisionsResponse(
        stamp=stamp(report.snapshot),
        touching=[_touch(one, told is None) for one in report.touching],
        events=map(_event, events),
        missed_events=missed,
        fault=report.fault,
        checks=report.checks,
        check_seconds=report.seconds,
    )


def _touch(touch: Touch, where: bool = True) -> collision_pb2.ReportedCollision:
    return collision_pb2.ReportedCollision(
        pair=pair_message(touch.names, touch.pair if where else replace(touch.pair, contacts=())),
        tolerated=touch.tolerated,
        tick=touch.tick,
        simulation_time_seconds=touch.simulation_time,
    )


def _event(event: Event) -> collision_pb2.CollisionEvent:
    message = collision_pb2.CollisionEvent(
        number=event.number, tick=event.tick, simulation_time_seconds=event.simulation_time
    )
    what = event.what
    if isinstance(what, Touch):
        message.begun.CopyFrom(_touch(what))
    elif isinstance(what, Ended):
        first, second = what.touch.names
        message.ended.CopyFrom(collision_pb2.EndedCollision(first=first, second=second, apart=what.apart))
    elif isinstance(what, Stopped):
        message.stopped.CopyFrom(
            collision_pb2.StoppedRobots(robots=what.robots, motion_ids=what.motions, reason=what.reason)
        )
    else:
        message.fault = what.fault
    return message


def cost_message(cost: GuardCost) -> collision_pb2.GuardCost:
    """Return the cost of guarding as a message."""
    mean = cost.seconds / cost.ticks if cost.ticks else 0.0
    return collision_pb2.GuardCost(ticks=cost.ticks, mean_seconds=mean, worst_seconds=cost.worst_seconds)
