"""A mobile manipulator drives to a shelf, looks, grasps what stands there, and brings it to a table.

The vehicle goes by the plan of the building, its lidar and its encoders; the arm by what its laser tells in the frame
of its own base. Plans are made in a second kernel that holds the arm and its map alone. Where things truly are is asked
for measuring alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import virtualrobot
from virtualrobot import Client, Motion
from virtualrobot.errors import WrongStateError
from virtualrobot.kernel_process import KernelProcess

from virtualrobot_apps.demos.carry.cell import ARM, FINGERS, HOME, OPEN, load_arm
from virtualrobot_apps.demos.fetch import cell
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.seeing import tabletop
from virtualrobot_apps.seeing.arms import Posture
from virtualrobot_apps.seeing.navigation import floors, journeys
from virtualrobot_apps.seeing.navigation.navigator import Goal
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, compose
from virtualrobot_apps.seeing.navigation.vehicle import Vehicle, sensors_of

RISE = 0.12
"""Height (m) over a grasp from which the tool goes straight down."""
GAP = 0.002
"""Height (m) over the table at which the fingers let go."""
LOOKS, NEARER = 3, 0.04
"""Number of looks at the shelf at most, and way (m) that the vehicle goes nearer from each to the next one."""


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a fetch: whether both fingers felt something, and how far (m) it is from its place on the table."""

    touched: bool
    off: float


class Fetcher:
    """Vehicle with an arm, and what both know."""

    def __init__(self, client: Client, mind: Client, pace: float) -> None:
        """Begin at the start, on the plan of the building."""
        self._client, self._mind, self._pace = client, mind, pace
        self._keeper, self._begun = Pace(pace), client.clock.read().stamp.simulation_time
        self._grid = floors.true_grid(cell.PLAN, 0.05, cell.ROOM)
        self._vehicle = Vehicle(client, cell.VEHICLE, *sensors_of(client, cell.VEHICLE))
        self._here = np.array(cell.START)
        self._arm = client.robot(ARM)
        self._home: Posture = dict(zip(self._arm.chain_joint_names, HOME, strict=True))

    def drive_to(self, name: str) -> None:
        """Go to before a place, and straight on to where the arm reaches it."""
        goal = Goal(*cell.before(name, cell.AWAY).tolist())
        (reached,) = journeys.go(
            self._client, self._vehicle, self._grid, [goal], self._here, watch=self._note, pace=self._pace
        )
        if not reached:
            raise WrongStateError(f"the vehicle has not come to the {name}")
        self.advance(float(np.linalg.norm(self._here[:2] - cell.PLACES[name])) - cell.NEAR)

    def advance(self, meters: float) -> None:
        """Go straight ahead, or back."""
        self._run(self._client.robot(cell.VEHICLE).way([[meters, 0.0, 0.0]]).start(wait=False))
        self._here = compose(self._here, arc(np.array([meters, 0.0]), np.array(1.0)))

    def look(self, name: str, held: tabletop.Thing | None = None) -> tabletop.Looks:
        """Look at a place from about home; return what was seen, in the frame of the arm's base."""
        looks = tabletop.Looks(self._client, cell.SETUP)
        looks.held = held
        looks.around()
        place = cell.base_t_place(self._here, name)
        if held is None:
            looks.closely(self._mind, place.tolist())
        self._keep()
        told = len(tabletop.occupied(looks.octree))
        print(f"looks at the {name}: {len(looks.cloud.points):,} echoes, {told:,} voxels occupied", flush=True)
        return looks

    def take(self) -> tuple[tabletop.Thing, bool]:
        """Take what stands at the shelf's place; return what it is, and whether both fingers feel it."""
        mind, thing = self._mind, self._found()
        wide, deep, high = np.round(1e3 * np.sort(thing.size))
        print(
            f"grasps: {wide:.0f} x {deep:.0f} x {high:.0f} mm, {1e3 * thing.width:.0f} mm between fingers", flush=True
        )
        over = mind.robot(ARM).solve_inverse(virtualrobot.pose(z=RISE) @ thing.grasp, seed=thing.posture).by_name()
        self._along(tabletop.path(mind, ARM, self._home, over))
        self._straight(thing.grasp)
        touched = tabletop.grip(self._client, ARM, FINGERS, thing.width)
        self._straight(virtualrobot.pose(z=RISE) @ thing.grasp)
        tabletop.hold(mind, ARM, thing)
        self._along(tabletop.path(mind, ARM, self._now(), self._home))
        return thing, touched

    def _found(self) -> tabletop.Thing:
        """Return what stands at the shelf's place; look again from nearer where it can't be grasped so."""
        for _ in range(LOOKS - 1):
            try:
                return self._seen()
            except WrongStateError as error:
                print(f"looks again: {error}", flush=True)
                self.advance(NEARER)
        return self._seen()

    def _seen(self) -> tabletop.Thing:
        looks, place = self.look("shelf"), cell.base_t_place(self._here, "shelf").tolist()
        return tabletop.thing_on(self._mind, cell.SETUP, looks.cloud, looks.octree, place)

    def put(self, thing: tabletop.Thing) -> None:
        """Put a thing down at the table's place."""
        looks, mind = self.look("table", thing), self._mind
        place = cell.base_t_place(self._here, "table")
        goal = thing.grasp.copy()
        goal[:2, 3] = place
        top = tabletop.top_of(looks.cloud, place.tolist(), cell.SETUP.half)
        goal[2, 3] += top - tabletop.bottom_of(thing) + GAP
        tabletop.tell(mind, tabletop.occupied(looks.octree))
        over = virtualrobot.pose(z=RISE) @ goal
        self._along(tabletop.path(mind, ARM, self._now(), over))
        self._straight(goal)
        self._arm.place()
        self._run(self._arm.tool().move_to_width(OPEN, wait=False))
        tabletop.let_go(mind, ARM)
        self._straight(over)
        self._along(tabletop.path(mind, ARM, self._now(), self._home))

    def _now(self) -> Posture:
        """Return the posture of the arm."""
        at = dict(zip(self._arm.joint_names, self._arm.positions.tolist(), strict=True))
        return {name: at[name] for name in self._arm.chain_joint_names}

    def _along(self, postures: list[Posture]) -> None:
        for posture in postures[1:]:
            self._run(self._arm.move_joints(posture, wait=False))

    def _straight(self, arm_t_tcp: Floats) -> None:
        """Move straight to a pose that is told in the frame of the arm's base, wherever that is in the world."""
        self._run(self._arm.move_linear(self._client.scene.pose(ARM) @ arm_t_tcp, wait=False))

    def _run(self, motion: Motion) -> None:
        self._client.clock.run(motion)
        self._keep()

    def _keep(self) -> None:
        self._keeper.keep(self._client.clock.read().stamp.simulation_time - self._begun)

    def _note(self, pose: Floats) -> None:
        self._here = pose


def main(client: Client, seed: int = 1, pace: float = 0.0) -> Result:
    """Replace the world by the room, fetch the prism, print how it went, and return it.

    Args:
        client: of the kernel.
        seed: of where on the shelf the prism stands.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.

    Raises:
        WrongStateError: where the vehicle comes to no place, nothing stands there, or no grasp is in reach.
    """
    client.clock.set_stepped()
    cell.build(client, seed)
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as mind:
        mind.scene.clear()
        load_arm(mind)
        back, ahead, side = cell.DECK
        deck = virtualrobot.box(ahead - back, 2.0 * side, 0.3, pose=virtualrobot.pose(0.5 * (back + ahead), 0.0, -0.16))
        mind.scene.add_object("deck", deck)
        fetcher = Fetcher(client, mind, pace)
        fetcher.drive_to("shelf")
        thing, touched = fetcher.take()
        fetcher.advance(cell.NEAR - cell.AWAY)
        fetcher.drive_to("table")
        fetcher.put(thing)
        fetcher.advance(cell.NEAR - cell.AWAY)
    at = client.scene.pose(cell.THING)[:3, 3]
    off = float(np.linalg.norm(at[:2] - cell.PLACES["table"]))
    felt = "both fingers felt it" if touched else "the fingers felt nothing"
    print(
        f"{felt}; it stands at ({at[0]:.2f}, {at[1]:.2f}, {at[2]:.2f}), {1e3 * off:.0f} mm from its place", flush=True
    )
    return Result(touched, off)
