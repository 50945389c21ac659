"""Command that puts the world back to how it was at a checkpoint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.apply_nodes import all_ended
from virtualrobot_kernel.world.apply_sensors import with_sensors_running
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.history_commands import RestoreWorld
from virtualrobot_kernel.world.state import EndCause, State


def checkpoint_of(change: Change, name: str) -> RestoreWorld:
    """Return the command that puts the world back to how it is now; motions and measured joints are left out."""
    state = replace(
        change.state,
        motions=(),
        ended=(),
        commanded={},
        readings={},
        motored={},
        efforts={},
        dynamics=None,
        moved_parts=None,
        contacts=None,
        told_contacts=None,
        stop=None,
    )
    return RestoreWorld(name, tuple(change.structure.nodes.values()), state)


def restore_world(change: Change, command: RestoreWorld, forward: Forward) -> Change:
    """Return the world as it was at a checkpoint, standing still; running motions end.

    Raises KernelError (WRONG_STATE) while joints are measured: nobody can put a real robot elsewhere.
    """
    now, then = change.state, command.state
    if now.commanded:
        name = change.structure.nodes[next(iter(now.commanded))].name
        raise KernelError(
            f"the joints of {name!r} are measured and cannot be put elsewhere; end that first",
            reason=Reason.WRONG_STATE,
            robot=name,
        )
    nodes = {node.uid: node for node in command.nodes}
    structure = index.build(nodes, max(change.structure.next_uid, *(uid + 1 for uid in nodes)), 0)
    cause = EndCause.WORLD_RESTORED
    state: State = replace(
        then,
        tick=now.tick,
        v=np.zeros(len(then.v)),
        motions=(),
        ended=(*now.ended, *all_ended(now, cause, f"the world went back to the checkpoint {command.checkpoint!r}")),
        motion_count=max(now.motion_count, then.motion_count),
        commanded={},
        readings={},
        motored={},
        efforts={},
        dynamics=None,
        moved_parts=None,
        contacts=None,
        told_contacts=None,
        twists={},
        running_sensors={},
        sensor_starts=max(now.sensor_starts, then.sensor_starts),
        epoch=max(now.epoch, then.epoch) + 1,
        stop=now.stop,
    )
    # Each start of a sensor has a number of its own.
    return with_sensors_running(replace(change, structure=structure, state=state), then.running_sensors, True)
