"""Environment of Gymnasium: a robot in the world of a scene, which learns by moving its joints; the reward is a user's.

It needs no kernel, no server and no clock: a step is a move of the joints by their speed times a period. Nothing falls
and nothing has mass in it. `gymnasium.make_vec` and the vector environments run many of them side by side.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import rows_from_poses

from virtualrobot_apps.studies.parameters import Floats
from virtualrobot_apps.studies.worlds import World, open_world

try:
    import gymnasium
    from gymnasium import spaces
except ModuleNotFoundError as error:
    said = f"environments need Gymnasium ({error}): pip install 'virtualrobot[learning]'"
    raise ModuleNotFoundError(said, name=error.name) from error

Observation = dict[str, NDArray[np.float64]]
Action = NDArray[np.float64]

_POSE = 7


@dataclass(frozen=True)
class Step:
    """Step that a robot has made, as the reward is told it.

    Attributes:
        number: of the step in this episode, from 1.
        world: as it is after the step.
        observation: of that.
        action: what was asked for, (k,) in -1 to 1.
        touching: names of two nodes that would have touched: the robot has stayed where it was; None otherwise.
    """

    number: int
    world: World
    observation: Observation
    action: Floats
    touching: tuple[str, str] | None


Reward = Callable[[Step], SupportsFloat | tuple[SupportsFloat, bool]]
"""Reward of a step, and whether the episode ends with it: the goal is reached, or all is lost."""
Begin = Callable[[World, np.random.Generator], None]
"""Change of a world as an episode begins: it puts a part or the robot elsewhere, by random numbers."""


class RobotEnvironment(gymnasium.Env[Observation, Action]):
    """Robot that moves its joints.

    An action (k,) is the speed of each joint, -1 to 1 of the greatest. A joint stays within its limits, and an arm
    that would touch something where it may not stays where it was.

    An observation has `joints` (k,), rad or m; `tool`, the pose of the tool centre point in the world's frame; and
    those of the nodes asked for, by name: x, y, z (m), and the unit quaternion x, y, z, w with w not negative.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  as Gymnasium's own has it

    def __init__(
        self,
        scene: str | os.PathLike[str] | World,
        robot: str,
        reward: Reward,
        *,
        nodes: Sequence[str] = (),
        begin: Begin | None = None,
        speed: float | Sequence[float] = 1.0,
        period: float = 0.05,
        steps: int = 200,
    ) -> None:
        """Open a scene.

        Args:
            scene: scene file, or a world that is open already.
            robot: name of the robot that moves.
            reward: called after each step.
            nodes: names of what is observed besides.
            begin: called as an episode begins, with the world as it was loaded.
            speed: greatest speed of the joints, of all or of each (rad/s or m/s).
            period: time (s) that a step stands for.
            steps: number of steps after which an episode is cut off.

        Raises:
            InvalidArgumentError: when speed, period or steps are not above 0, or a node is called `joints` or `tool`.
            Exception: what is wrong in the scene, in words.
        """
        self._world = open_world(Path(scene)) if isinstance(scene, str | os.PathLike) else scene
        self._robot, self._reward, self._begin, self._steps = robot, reward, begin, steps
        self._names = tuple(self._world.joints(robot))
        self._limits, count = self._world.joint_limits(robot), len(self._names)
        speeds = np.asarray(speed, dtype=np.float64)
        if speeds.shape not in ((), (count,)) or not (np.isfinite(speeds).all() and (speeds > 0.0).all()):
            raise InvalidArgumentError(f"speed is above 0, one for all or each of {count} joints, not {speed!r}")
        if not (0.0 < period < np.inf and steps >= 1):
            raise InvalidArgumentError(f"period is above 0 and steps 1 or more, not {period!r} and {steps!r}")
        if wrong := sorted({"joints", "tool"} & set(nodes)):
            raise InvalidArgumentError(f"{wrong[0]!r} is observed of every robot: give the node another name")
        self._reaches = np.broadcast_to(speeds * period, (count,))
        self._nodes, self._number = tuple(nodes), 0
        self.action_space = spaces.Box(-1.0, 1.0, (count,), np.float64)
        poses = {name: spaces.Box(-np.inf, np.inf, (_POSE,), np.float64) for name in ("tool", *self._nodes)}
        self.observation_space: Any = spaces.Dict(
            {"joints": spaces.Box(self._limits[:, 0], self._limits[:, 1], (count,), np.float64), **poses}
        )
        self._observation()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode: go back to the world as it was loaded, and let `begin` change it.

        The same seed gives the same episodes.
        """
        super().reset(seed=seed, options=options)
        self._number = 0
        self._world.restore()
        if self._begin is not None:
            self._begin(self._world, self.np_random)
        return self._observation(), {}

    def step(self, action: Action) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Move the joints by an action (k,); what is beyond -1 or 1 counts as that.

        `info` has `touching`: the names of two nodes, where the arm has stayed where it was.

        Raises:
            InvalidArgumentError: when the action has another shape, or is not finite.
        """
        asked = np.asarray(action, dtype=np.float64)
        if asked.shape != self._reaches.shape or not np.isfinite(asked).all():
            raise InvalidArgumentError(f"an action is {self._reaches.shape} and finite, not {action!r}")
        asked = np.clip(asked, -1.0, 1.0)
        now = np.array(list(self._world.joints(self._robot).values()))
        wanted = np.clip(now + asked * self._reaches, self._limits[:, 0], self._limits[:, 1])
        touching = self._world.touching(self._robot, wanted)
        if touching is None:
            self._world.set_joints(self._robot, dict(zip(self._names, wanted.tolist(), strict=True)))
        self._number += 1
        observation = self._observation()
        answer = self._reward(Step(self._number, self._world, observation, asked, touching))
        reward, is_over = answer if isinstance(answer, tuple) else (answer, False)
        info = {} if touching is None else {"touching": touching}
        return observation, float(reward), bool(is_over), self._number >= self._steps, info

    def close(self) -> None:
        """Close the world."""
        self._world.close()

    def _observation(self) -> Observation:
        joints = np.clip(list(self._world.joints(self._robot).values()), self._limits[:, 0], self._limits[:, 1])
        poses = {"tool": self._world.tool_pose(self._robot), **{name: self._world.pose(name) for name in self._nodes}}
        return {"joints": joints, **{name: rows_from_poses(pose)[0] for name, pose in poses.items()}}
