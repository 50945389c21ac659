"""Codes of `simulation_interfaces`, and refusals that carry one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from virtualrobot.errors import (
    InvalidArgumentError,
    MalformedFileError,
    MissingFileError,
    NameTakenError,
    UnknownNameError,
    VirtualRobotError,
)

from virtualrobot_apps.bridges.ros.mapping.basics import RosValue
from virtualrobot_apps.bridges.ros.messages.types import make

PACKAGE = "simulation_interfaces"

FEATURE_UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, OPERATION_FAILED = range(5)
"""Results of any service; source: simulation_interfaces/msg/Result."""

NAME_NOT_UNIQUE, NAME_INVALID, UNSUPPORTED_FORMAT, NO_RESOURCE, NAMESPACE_INVALID = range(101, 106)
RESOURCE_PARSE_ERROR, MISSING_ASSETS, UNSUPPORTED_ASSETS, INVALID_POSE = range(106, 110)
"""Results of SpawnEntity; source: simulation_interfaces/srv/SpawnEntity."""

ENTITIES_SPAWN_FAILED = 150
ALREADY_IN_TARGET_STATE, NO_WORLD_LOADED = 101, 101
WORLD_UNSUPPORTED_FORMAT, WORLD_NO_RESOURCE, WORLD_PARSE_ERROR, WORLD_MISSING_ASSETS = range(101, 105)
"""Results of SpawnEntities, SetSimulationState, GetCurrentWorld with UnloadWorld, and LoadWorld."""

Codes: TypeAlias = Mapping[type[VirtualRobotError], int]

SPAWN_CODES: Codes = {
    NameTakenError: NAME_NOT_UNIQUE,
    MissingFileError: MISSING_ASSETS,
    MalformedFileError: RESOURCE_PARSE_ERROR,
    InvalidArgumentError: UNSUPPORTED_FORMAT,
}
WORLD_CODES: Codes = {
    MissingFileError: WORLD_MISSING_ASSETS,
    MalformedFileError: WORLD_PARSE_ERROR,
    InvalidArgumentError: WORLD_UNSUPPORTED_FORMAT,
}
_CODES: Codes = {UnknownNameError: NOT_FOUND}


class RefusedError(Exception):
    """A request that is refused; `code` is that of its Result."""

    def __init__(self, code: int, words: str) -> None:
        """Say what is wrong."""
        super().__init__(words)
        self.code = code


def result(code: int = OK, words: str = "") -> RosValue:
    """Return a `simulation_interfaces/Result`."""
    return make(f"{PACKAGE}/msg/Result", result=code, error_message=words)


def code_of(error: Exception, codes: Codes) -> int:
    """Return the code of an error: its own, that of its class in `codes`, or OPERATION_FAILED."""
    if isinstance(error, RefusedError):
        return error.code
    return next((code for kind, code in {**codes, **_CODES}.items() if isinstance(error, kind)), OPERATION_FAILED)
