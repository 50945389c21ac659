"""Leads the tool of an arm by velocity setpoints while its links keep away from obstacles, cycle by cycle.

In each cycle the kernel tells how far links are from obstacles and how points of them move with the joints;
`avoidance.law` says what follows. In REALTIME a cycle is as long as states come, 60 a second; in STEPPED it is a few
ticks, and the same start gives the same joints bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from virtualrobot import Client, Robot
from virtualrobot.motions.setpoints import SetpointStream
from virtualrobot.robots.values import Jacobians

from virtualrobot_apps.demos.avoidance import law

Floats = NDArray[np.float64]

RECORDED = 0.5
"""Range of the distances from links to their nearest obstacles (m); beyond, this is the distance."""
SPEED_SHARE = 0.9
"""The part of the joints' greatest velocities that is used: setpoints above them would be refused."""
CYCLE_TICKS = 5
"""Length of a cycle in STEPPED mode (ticks)."""


@dataclass(frozen=True, slots=True)
class Gains:
    """The constants of the control law, with the paper's symbols; meters, radians, seconds.

    Attributes:
        k_p: K_p, of the position error (1/s).
        k_o: K_o, of the orientation error (1/s); that error is half the angle.
        alpha: below 0, of the subtask; 0 switches it off.
        k_r: of the potential; it has its unit with alpha, m^3 rad/s.
        eta_0: the range of influence of obstacles on links, at most RECORDED.
        reach: the distance below which the tool gives way, at most RECORDED.
        repulsion: the greatest velocity with which it does; 0 switches it off.
    """

    k_p: float = 5.0
    k_o: float = 10.0
    alpha: float = -1.0
    k_r: float = 0.004
    eta_0: float = 0.3
    reach: float = 0.15
    repulsion: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Pose (4, 4) and velocities, (3,) m/s and (3,) rad/s, that a tool shall have, in the world's frame."""

    world_t_tcp: Floats
    velocity: Floats
    turning: Floats


Trajectory = Callable[[float], Reference]
"""Function of the seconds since the start: pose and velocities that the tool shall have then."""


class Near(Protocol):
    """Point of the robot and one of an obstacle: `virtualrobot.collisions.Distance` is such."""

    @property
    def first(self) -> str:
        """Return the link or tool that the point is fixed to."""
        ...

    @property
    def distance(self) -> float:
        """Return the distance of both (m)."""
        ...

    @property
    def points(self) -> Floats:
        """Return both (2, 3) in the world's frame, the robot's first."""
        ...


Sight = Callable[[Mapping[str, float]], Sequence[Near]]
"""Function of joint positions by name: what is near the robot then, the nearest first."""


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Record of n cycles.

    Attributes:
        links: those that came within RECORDED of an obstacle.
        times: (n,) seconds since the start.
        positions: (n, k) of the joints.
        distances: (n, l) of each link to its nearest obstacle, at most RECORDED (m).
        errors: (n, 3) position errors, from the tool to its goal (m).
    """

    links: tuple[str, ...]
    times: Floats
    positions: Floats
    distances: Floats
    errors: Floats

    @property
    def least(self) -> Floats:
        """(n,) the least distance of any link."""
        return self.distances.min(axis=1, initial=RECORDED)

    def of_link(self, link: str) -> Floats:
        """Return the distance (n,) of a link."""
        return self.distances[:, self.links.index(link)] if link in self.links else np.full(len(self.times), RECORDED)


def track(
    client: Client,
    robot: Robot,
    trajectory: Trajectory,
    seconds: float,
    gains: Gains,
    each: Callable[[float], None] = lambda time: None,
    sight: Sight | None = None,
) -> Record:
    """Lead the chosen tool centre point along a trajectory for so many seconds of simulation time, and stop it.

    Args:
        client: of the kernel.
        robot: an arm with more than six joints.
        trajectory: the poses and velocities that the tool shall have.
        seconds: the duration, in s of simulation time.
        gains: the constants of the law.
        each: is called at the beginning of each cycle with the seconds since the start.
        sight: what the law knows of obstacles; by default the true distances of links from them.
    """

    def measured(at: Mapping[str, float]) -> Sequence[Near]:
        return client.collisions.distances(robot.name, max_distance=RECORDED, configurations={robot.name: at})

    sight = sight or measured
    names, limits = robot.chain_joint_names, robot.limits
    lower, upper, fastest = (
        np.array([getattr(limits[name], field) for name in names]) for field in ("lower", "upper", "velocity")
    )
    rows: list[tuple[float, Floats, dict[str, float], Floats]] = []
    stepped = client.clock.mode == "stepped"
    with robot.stream("velocity", names) as stream:
        for time, q, going in _steps(client, robot, stream) if stepped else _moments(stream):
            if time > seconds:
                break
            each(time)
            at = dict(zip(names, q.tolist(), strict=True))
            near = sight(at)
            told = robot.solve_jacobian(at, [(pair.first, pair.points[0]) for pair in near])
            reference = trajectory(time)
            weights = law.limit_weights(q, going, lower, upper)
            stream.send(command(near, told, names, reference, gains, weights, SPEED_SHARE * fastest), wait=stepped)
            distances: dict[str, float] = {}
            for pair in near:
                distances.setdefault(pair.first, pair.distance)  # the nearest comes first
            rows.append((time, q, distances, law.position_error(told.world_t_tcp, reference.world_t_tcp)))
        if stepped:
            stream.cancel()  # to close it would wait for steps
    while stepped and client.clock.step().robots[robot.name].motion_ids:
        pass
    links = tuple(link for link in robot.links if any(link in distances for _, _, distances, _ in rows))
    return Record(
        links,
        np.array([time for time, _, _, _ in rows]),
        np.array([q for _, q, _, _ in rows]),
        np.array([[distances.get(link, RECORDED) for link in links] for _, _, distances, _ in rows]),
        np.array([error for _, _, _, error in rows]),
    )


def command(
    near: Sequence[Near],
    told: Jacobians,
    names: list[str],
    reference: Reference,
    gains: Gains,
    weights: Floats,
    limits: Floats,
) -> Floats:
    """Return the joint velocities (k,) of equation 1.

    Args:
        near: distances of links and tool to obstacles.
        told: the Jacobians of tool and nearest points, in the order of `near`.
        names: the k joints that lead the tool.
        reference: the pose and velocities that the tool shall have.
        gains: the constants of the law.
        weights: the diagonal of W (k,).
        limits: the joints' greatest velocities (k,).
    """
    columns = [told.joint_names.index(name) for name in names]
    tool, points = told.tcp[:, columns], told.points[:, :, columns]
    ours, theirs = (np.array([pair.points[side] for pair in near]).reshape(-1, 3) for side in (0, 1))
    eta = np.array([pair.distance for pair in near])
    velocity = gains.k_p * law.position_error(told.world_t_tcp, reference.world_t_tcp) + reference.velocity
    if gains.repulsion:
        # What the last joint turns, turns as the tool does.
        carried = (np.abs(points[:, 3:] - tool[3:]) < 1e-9).all(axis=(1, 2))
        velocity = velocity + law.repulsive_velocity(ours[carried], theirs[carried], gains.reach, gains.repulsion)
    turning = gains.k_o * law.orientation_error(told.world_t_tcp, reference.world_t_tcp) + reference.turning
    gradients = law.distance_gradients(ours, theirs, points[:, :3])
    gradient = law.subtask_gradient(eta, gradients, gains.eta_0, gains.k_r)
    return law.joint_velocities(tool, weights, np.concatenate([velocity, turning]), gradient, gains.alpha, limits)


def _moments(stream: SetpointStream) -> Iterator[tuple[float, Floats, Floats]]:
    """Yield seconds since the start, positions and velocities whenever there is news."""
    start = stream.state.time
    for state in stream:
        yield state.time - start, state.positions, state.velocities


def _steps(client: Client, robot: Robot, stream: SetpointStream) -> Iterator[tuple[float, Floats, Floats]]:
    """Yield likewise, and let time go on by a cycle after each."""
    columns = [robot.joint_names.index(name) for name in stream.joint_names]
    tick, state = client.clock.read().tick_length, robot.state
    cycle = 0
    while True:
        yield cycle * CYCLE_TICKS * tick, state.positions[columns], state.velocities[columns]
        state = client.clock.step(CYCLE_TICKS).robots[robot.name]
        cycle += 1
