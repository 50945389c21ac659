"""Services and the action of `simulation_interfaces` 2.1, or 1.0, on a hub, under `/virtualrobot`."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Awaitable, Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.bridges.ros.hub import CANCELED, SUCCEEDED, Action, Feedback, Hub, Service
from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.types import make
from virtualrobot_apps.bridges.ros.messages.values import default
from virtualrobot_apps.bridges.ros.simulation.entities import Entities, is_first, spawnables, tagged
from virtualrobot_apps.bridges.ros.simulation.results import (
    ALREADY_IN_TARGET_STATE,
    ENTITIES_SPAWN_FAILED,
    FEATURE_UNSUPPORTED,
    NO_WORLD_LOADED,
    OK,
    OPERATION_FAILED,
    PACKAGE,
    SPAWN_CODES,
    WORLD_CODES,
    WORLD_NO_RESOURCE,
    Codes,
    RefusedError,
    code_of,
    result,
)

NAMESPACE = "/virtualrobot"
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD = range(5)
"""States; source: simulation_interfaces/msg/SimulationState."""

STATE, SPAWNED, ALL = 2, 4, 255
"""Scopes of a reset; source: simulation_interfaces/srv/ResetSimulation."""

FEATURES = (
    *(0, 1, 2),  # spawning, deleting, named poses
    *(4, 5, 6, 8),  # tags, bounds, boxes, categories
    *(9, 10, 11, 12, 14),  # texts of resources, states told and set, info told, spawnables
    *(20, 22, 23),  # reset: of state, of what was spawned
    *(24, 25, 26),  # state told, set, pause
    *(31, 32, 33),  # one step, several, the action
    *(40, 41, 42, 43, 44, 45),  # worlds: loading, texts, tags, unloading, told, listed
    50,  # spawning of several
)
"""Features that are there; source: simulation_interfaces/msg/SimulatorFeatures."""

NEW_SERVICES = ("spawn_entities", "load_world", "unload_world", "get_current_world", "get_available_worlds")
NEW_FEATURES = range(40, 51)
"""Services and features that version 1.0 lacks."""

_MOST_STEPS = 1_000_000
_MOST_STEPS_A_CALL, _FEEDBACKS = 1000, 1000
_ENDINGS = (".yaml", ".yml")


class Simulation:
    """World of a kernel as a simulation of ROS: its requests are answered in threads, one after the other."""

    def __init__(self, client: Client, hub: Hub, *, bare: bool = False, name: str = "the bridge") -> None:
        """Serve nothing yet; under `name` the world is kept as it is at the start, so each bridge has its own."""
        self._client, self._hub, self._start = client, hub, f"start of {name}"
        self._entities = Entities(client, bare=bare)
        self._stopped = False
        self._world: RosValue | None = make(
            f"{PACKAGE}/msg/WorldResource",
            **{"name": "world", "world_resource": default(f"{PACKAGE}/msg/Resource"), "description": "", "tags": []},
        )
        self._lock = asyncio.Lock()

    async def keep(self) -> None:
        """Keep the world as it is now, which a reset goes back to.

        Raises:
            VirtualRobotError: where the world may not be changed, such as RoleTooLowError.
        """
        await asyncio.to_thread(self._keep)

    async def close(self) -> None:
        """Keep it no more; raises nothing."""
        with suppress(VirtualRobotError):  # the kernel has gone, or it was never kept
            await asyncio.to_thread(self._client.history.remove_checkpoint, self._start)

    def serve(self) -> None:
        """Add the services and the action to the hub."""
        entities = self._entities
        answers: dict[str, tuple[str, Callable[[RosValue], dict[str, object]], Codes]] = {
            "get_simulator_features": ("GetSimulatorFeatures", self._features, {}),
            "get_entities": ("GetEntities", lambda asked: {"entities": entities.matching(asked.filters)}, {}),
            "get_entities_states": ("GetEntitiesStates", self._states, {}),
            "get_entity_state": (
                "GetEntityState",
                lambda asked: {"state": entities.states([asked.entity], self._hub.now)[0]},
                {},
            ),
            "set_entity_state": ("SetEntityState", self._set_state, {}),
            "get_entity_info": ("GetEntityInfo", lambda asked: {"info": entities.info(asked.entity)}, {}),
            "get_entity_bounds": ("GetEntityBounds", lambda asked: {"bounds": entities.bounds(asked.entity)}, {}),
            "spawn_entity": ("SpawnEntity", self._spawn, SPAWN_CODES),
            "spawn_entities": ("SpawnEntities", self._spawn_all, {}),
            "delete_entity": ("DeleteEntity", self._delete, {}),
            "get_spawnables": ("GetSpawnables", self._spawnables, {}),
            "get_named_poses": ("GetNamedPoses", lambda asked: {"poses": entities.named_poses(asked.tags)}, {}),
            "get_simulation_state": ("GetSimulationState", self._state, {}),
            "set_simulation_state": ("SetSimulationState", self._set_simulation_state, {}),
            "step_simulation": ("StepSimulation", self._step, {}),
            "reset_simulation": ("ResetSimulation", self._reset, {}),
            "load_world": ("LoadWorld", self._load_world, WORLD_CODES),
            "unload_world": ("UnloadWorld", self._unload_world, {}),
            "get_current_world": ("GetCurrentWorld", lambda _: {"world": self._loaded()}, {}),
            "get_available_worlds": ("GetAvailableWorlds", self._worlds, {}),
        }
        for name, (base, answer, codes) in answers.items():
            if is_first() and name in NEW_SERVICES:
                continue
            type = f"{PACKAGE}/srv/{base}"
            work = partial(self._answered, f"{type}_Response", answer, codes)
            self._hub.serve(Service(f"{NAMESPACE}/{name}", type, work))
        self._hub.act(Action(f"{NAMESPACE}/simulate_steps", f"{PACKAGE}/action/SimulateSteps", self._simulate))

    def _answered(
        self, type: str, answer: Callable[[RosValue], dict[str, object]], codes: Codes, request: RosValue
    ) -> Awaitable[RosValue]:
        """Return the response: what `answer` gives, or a Result with the code and the words of what it has raised."""

        async def made() -> RosValue:
            response = default(type)
            try:
                async with self._lock:
                    told = await asyncio.to_thread(answer, request)
                if hasattr(response, "result"):
                    response.result = result()
            except (RefusedError, VirtualRobotError) as error:
                told = {"result": result(code_of(error, codes), str(error))}
            for key, value in told.items():
                setattr(response, key, value)
            return response

        return made()

    def _features(self, _: RosValue) -> dict[str, object]:
        formats = [one.removeprefix(".") for one in self._client.info.model_formats]
        words = "https://pypi.org/project/virtualrobot: a reset leaves the time as it is"
        features = np.array([one for one in FEATURES if not (is_first() and one in NEW_FEATURES)], np.uint16)
        return {
            "features": make(
                f"{PACKAGE}/msg/SimulatorFeatures", features=features, spawn_formats=formats, custom_info=words
            )
        }

    # Entities.

    def _states(self, asked: RosValue) -> dict[str, object]:
        names = self._entities.matching(asked.filters)
        return {"entities": names, "states": self._entities.states(names, self._hub.now)}

    def _set_state(self, asked: RosValue) -> dict[str, object]:
        self._entities.set_state(asked.entity, asked)
        return {}

    def _delete(self, asked: RosValue) -> dict[str, object]:
        self._entities.delete(asked.entity)
        return {}

    def _spawn(self, asked: RosValue) -> dict[str, object]:
        return {"entity_name": self._entities.spawn(asked)}

    def _spawn_all(self, asked: RosValue) -> dict[str, object]:
        told: list[RosValue] = []
        for one in asked.spawn_requests:
            try:
                name, outcome = self._entities.spawn(one), result()
            except (RefusedError, VirtualRobotError) as error:
                name, outcome = "", result(code_of(error, SPAWN_CODES), str(error))
            told.append(make(f"{PACKAGE}/msg/SpawnResult", result=outcome, entity_name=name))
        failed = sum(one.result.result != OK for one in told)
        words = f"{failed} of {len(told)} entities were not spawned"
        return {"results": told, **({"result": result(ENTITIES_SPAWN_FAILED, words)} if failed else {})}

    def _spawnables(self, asked: RosValue) -> dict[str, object]:
        words = f"unknown sources: {', '.join(asked.sources)}" if asked.sources else ""
        return {"spawnables": [*spawnables(self._client)], "result": result(OK, words)}

    # Time.

    def _state(self, _: RosValue) -> dict[str, object]:
        state = PLAYING if self._client.clock.mode == "realtime" else STOPPED if self._stopped else PAUSED
        if self._world is None and state != PLAYING:
            state = NO_WORLD
        return {"state": make(f"{PACKAGE}/msg/SimulationState", state=state)}

    def _set_simulation_state(self, asked: RosValue) -> dict[str, object]:
        wanted = asked.state.state
        if wanted not in (STOPPED, PLAYING, PAUSED):
            words = "a bridge does not end its kernel" if wanted == QUITTING else "a state that can be set is 0, 1 or 2"
            raise RefusedError(FEATURE_UNSUPPORTED, words)
        state: RosValue = self._state(None)["state"]
        if state.state == wanted:
            raise RefusedError(ALREADY_IN_TARGET_STATE, "the simulation is in this state already")
        if wanted == PLAYING:
            self._client.clock.set_realtime()
        else:
            self._client.clock.set_stepped()
        self._stopped = wanted == STOPPED
        if self._stopped:
            self._restore()
        return {}

    def _check_paused(self) -> None:
        if self._client.clock.mode != "stepped":
            raise RefusedError(OPERATION_FAILED, "time goes on by itself: pause the simulation first")

    def _step(self, asked: RosValue) -> dict[str, object]:
        self._check_paused()
        left = asked.steps
        if left > _MOST_STEPS:
            words = f"{_MOST_STEPS} steps are the most; the action simulate_steps takes more, and can be cancelled"
            raise RefusedError(OPERATION_FAILED, words)
        while left > 0:
            left -= self._client.clock.step(min(left, _MOST_STEPS_A_CALL)).ticks
            self._stopped = False
        return {}

    async def _simulate(self, goal: RosValue, feedback: Feedback, cancel: asyncio.Event) -> tuple[int, RosValue]:
        """Run a goal of SimulateSteps; feedback comes after each step, or a thousand times."""
        type, done = f"{PACKAGE}/action/SimulateSteps", 0
        outcome = result()
        try:
            async with self._lock:
                await asyncio.to_thread(self._check_paused)
                while done < goal.steps and not cancel.is_set():
                    ticks = min(max(1, goal.steps // _FEEDBACKS), goal.steps - done, _MOST_STEPS_A_CALL)
                    done += (await asyncio.to_thread(self._client.clock.step, ticks)).ticks
                    self._stopped = False
                    feedback(make(f"{type}_Feedback", completed_steps=done, remaining_steps=goal.steps - done))
        except (RefusedError, VirtualRobotError) as error:
            outcome = result(code_of(error, {}), str(error))
        status = CANCELED if cancel.is_set() and done < goal.steps else SUCCEEDED
        return status, make(f"{type}_Result", result=outcome)

    def _reset(self, asked: RosValue) -> dict[str, object]:
        scope = asked.scope or ALL
        if scope != ALL and scope & ~(STATE | SPAWNED):
            words = "the time goes on; the state (2) and what was spawned (4) are reset"
            raise RefusedError(FEATURE_UNSUPPORTED, words)
        if scope & STATE:
            if not scope & SPAWNED and self._entities.spawned:
                raise RefusedError(FEATURE_UNSUPPORTED, "the state (2) is reset with what was spawned (4)")
            self._restore()
        else:
            self._entities.delete_spawned()
        return {}

    # Worlds.

    def _keep(self) -> None:
        if self._start in self._client.history.checkpoints:
            self._client.history.remove_checkpoint(self._start)
        self._client.history.checkpoint(self._start)

    def _restore(self) -> None:
        before = self._client.history.restore(self._start)
        self._client.history.remove_checkpoint(before.name)
        self._entities.spawned.clear()

    def _loaded(self) -> RosValue:
        if self._world is None:
            raise RefusedError(NO_WORLD_LOADED, "no world is loaded")
        return self._world

    def _load_world(self, asked: RosValue) -> dict[str, object]:
        resource = asked.world_resource
        if not resource.uri and not resource.resource_string:
            raise RefusedError(WORLD_NO_RESOURCE, "'uri' names a scene file, or 'resource_string' is one")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(resource.uri.removeprefix("file://") or Path(folder) / "world.yaml")
            if not resource.uri:
                path.write_text(resource.resource_string, "utf-8")
            self._client.scene.load_scene(path, strict=asked.fail_on_unsupported_element)
        self._client.clock.set_stepped()
        self._stopped = True
        self._entities.spawned.clear()
        self._keep()
        self._world = _world(path.stem, resource)
        return {"world": self._world}

    def _unload_world(self, _: RosValue) -> dict[str, object]:
        self._loaded()
        self._client.clock.set_stepped()
        self._client.scene.clear()
        self._entities.spawned.clear()
        self._keep()
        self._world, self._stopped = None, True
        return {}

    def _worlds(self, asked: RosValue) -> dict[str, object]:
        """Return the scene files of the folders that are asked for; there are none beside them."""
        found: list[RosValue] = []
        failed: list[str] = []
        for source in asked.additional_sources:
            folder = Path(source.removeprefix("file://"))
            if not folder.is_dir():
                failed.append(source)
                continue
            files = sorted(one for one in folder.iterdir() if one.suffix in _ENDINGS)
            found += [
                _world(one.stem, make(f"{PACKAGE}/msg/Resource", uri=str(one), resource_string="")) for one in files
            ]
        found = [one for one in found if tagged([], asked.filter)]
        words = f"there is no folder {', '.join(failed)}" if failed else ""
        if failed and not (asked.continue_on_error and found):
            raise RefusedError(OPERATION_FAILED, words)
        return {"worlds": found, "result": result(OK, words)}


def _world(name: str, resource: RosValue) -> RosValue:
    return make(f"{PACKAGE}/msg/WorldResource", name=name, world_resource=resource, description="", tags=[])
