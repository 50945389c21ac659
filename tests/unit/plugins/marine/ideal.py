"""Vehicles for tests: files with some of their values changed, and thrusters whose thrust is their speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml
from virtualrobot_plugins.marine.component import FossenDynamics, FossenSettings
from virtualrobot_plugins.marine.vehicle import FOLDER, read_document
from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.vehicles import Surroundings

DEEP = Surroundings(surface=1000.0, gravity=9.82)
"""Fresh water, deep enough; gravity is that of the paper of the BlueROV2."""


def document(name: str = "bluerov2_heavy", **changed: Any) -> dict[str, Any]:  # noqa: ANN401  any value of a file
    """Return the document of a bundled vehicle with some of its values changed, their units and sources kept."""
    found = yaml.safe_load((FOLDER / f"{name}.yaml").read_text("utf-8"))
    for key, value in changed.items():
        whole = isinstance(value, dict) or not isinstance(found.get(key), dict)
        found[key] = value if whole else {**found[key], "value": value}
    return found


def pusher(name: str, direction: Sequence[float], position: Sequence[float], lag: float = 0.0) -> dict[str, Any]:
    """Return a thruster whose thrust (N) is its speed (rad/s), up to 200."""
    return {
        "name": name,
        "position": {"value": list(position), "unit": "m", "source": "assumed"},
        "direction": list(direction),
        "thrust": {"of": [-200, 200], "of_unit": "rad/s", "value": [-200, 200], "unit": "N", "source": "assumed"},
        "time_constant": {"value": lag, "unit": "s", "source": "assumed"},
    }


def vehicle(
    integrator: str = "rk4",
    longest: float = 0.005,
    carried_density: float = 0.0,
    **changed: Any,  # noqa: ANN401
) -> FossenDynamics:
    """Return the dynamics of a changed BlueROV2, whose weight is its buoyancy."""
    changed = {"volume": 13.5, **changed}
    made = read_document(document(**changed))
    settings = FossenSettings(made, integrator, longest, carried_density)  # pyright: ignore[reportArgumentType]
    return FossenDynamics(settings)


def run(
    dynamics: FossenDynamics,
    commands: Floats,
    seconds: float,
    dt: float = 0.004,
    pose: Floats | None = None,
    twist: Floats | None = None,
    states: Floats | None = None,
    water: Surroundings = DEEP,
) -> tuple[Floats, Floats, Floats]:
    """Return pose, twist and drives after steps of dt."""
    at = (
        np.eye(4) if pose is None else pose,
        np.zeros(6) if twist is None else np.asarray(twist, dtype=np.float64),
        np.zeros(len(dynamics.drives)) if states is None else states,
    )
    for _ in range(round(seconds / dt)):
        at = dynamics.step(*at, commands, dt, water)
    return at
