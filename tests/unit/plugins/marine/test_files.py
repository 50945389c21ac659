"""Files of vehicles: units, sources, and what no vehicle can be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from virtualrobot_plugins.marine.component import FossenSettings
from virtualrobot_plugins.marine.parameters import parameters
from virtualrobot_plugins.marine.vehicle import FOLDER, read_bundled, read_document
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.settings import make_settings

from tests.unit.plugins.marine.ideal import document


def made(**changed: Any) -> None:  # noqa: ANN401  any value of a file
    parameters(read_document(document(**changed)))


def thruster(**changed: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Return the thrusters, the first of them changed."""
    return [{**one, **(changed if i == 0 else {})} for i, one in enumerate(document()["thrusters"])]


def table(of: list[float], value: list[float], of_unit: str = "rpm", unit: str = "N") -> dict[str, Any]:
    return {"of": of, "of_unit": of_unit, "value": value, "unit": unit, "source": "t200"}


def quantity(value: float, unit: str, source: str = "benzon") -> dict[str, Any]:
    return {"value": value, "unit": unit, "source": source}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"mass": -1.0}, r"mass is -1.0; it must be above 0"),
        ({"mass": {"value": 13.5, "unit": "m", "source": "benzon"}}, r"mass has the unit 'm'; a mass is in kg or g"),
        ({"mass": {"value": 13.5, "unit": "kg"}}, r"missing required field `source` - at `\$.mass`"),
        ({"mass": quantity(13.5, "kg", "hearsay")}, r"the source of mass is 'hearsay'; it must be a key of `sources`"),
        ({"volume": 0.0}, r"volume is 0.0; it must be above 0"),
        ({"inertia": [0.1, 0.1, 0.3]}, r"inertia is .* none greater than the other two together"),
        ({"inertia": [-0.1, 0.1, 0.1]}, r"inertia is .* it must be of principal moments above 0"),
        ({"added_mass": [-6.36, 1, 1, 1, 1, 1]}, r"added_mass is of least eigenvalue -6.36; .* sign of a mass"),
        ({"linear_damping": [-1, 1, 1, 1, 1, 1]}, r"linear_damping is .* 0 or more on the diagonal"),
        ({"thrusters": []}, r"neither thrusters nor fins"),
        ({"thrusters": thruster(name="front_left")}, r"2 drives are called 'front_left'"),
        (
            {"thrusters": thruster(thrust=table([-1, 0, 1, 2], [-3, 0, 5, 4]))},
            r"thrusters\[0\] \(front_right\).thrust is 5 at 1 and 4 at 2; it must be monotone, nowhere falling",
        ),
        (
            {"thrusters": thruster(thrust=table([0, 2, 1], [0, 1, 2]))},
            r"thrusters\[0\] \(front_right\).thrust is 2 before 1; it must be of rising arguments",
        ),
        ({"thrusters": thruster(thrust=table([0, 1], [0]))}, r"2 arguments with 1 values"),
        ({"thrusters": thruster(thrust=table([0, 1], [0, 1], of_unit="m"))}, r"has the unit 'm'; a turning speed"),
        ({"thrusters": thruster(direction=[1, 1, 0])}, r"direction is \[1.0, 1.0, 0.0\]; it must be of length 1"),
        ({"thrusters": thruster(time_constant=quantity(-1, "s"))}, r"time_constant is -1.0; it must be 0 or more"),
        ({"axes": "north_east_down"}, r"'north_east_down' - at `\$.axes`"),
        ({"added_mass": [1, 2]}, r"length >= 6 - at `\$.added_mass.value`"),
        ({"added_mass": [1, 2, 3, 4, 5, [1] * 6]}, r"it must be either a diagonal or rows alone"),
        ({"mass": float("nan")}, r"mass is nan; it must be a finite number"),
    ],
)
def test_what_no_vehicle_can_be_is_refused_by_its_place(changed: dict[str, Any], said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        made(**changed)


def test_a_fin_lifts_across_the_stream() -> None:
    wrong = document("remus100")
    wrong["fins"][0]["direction"] = [0.6, -0.8, 0]
    with pytest.raises(ArgumentError, match=r"fins\[0\] \(rudder\).direction is .* at right angles to x"):
        parameters(read_document(wrong))


def test_an_unknown_vehicle_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(ArgumentError, match=r"no vehicle 'nautilus'; the bundled ones are bluerov2_heavy, remus100"):
        read_bundled("nautilus")


def test_units_and_axes_say_the_same_vehicle() -> None:
    """Written in grams and millimetres, and with z up, it is the same."""
    own = document()
    other = document(
        mass=13500.0,
        center_of_buoyancy=[0, 0, 10.0],
        axes="forward_left_up",
    )
    other["mass"]["unit"], other["center_of_buoyancy"]["unit"] = "g", "mm"
    for thruster in other["thrusters"]:
        for vector in (thruster["direction"], thruster["position"]["value"]):
            if vector[2] or vector[1]:
                vector[1], vector[2] = -vector[1], -vector[2]
    a, b = (parameters(read_document(one)) for one in (own, other))
    for name in ("mass_matrix", "hull", "drive", "tables"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-14, atol=1e-14)


def test_a_whole_file_can_be_the_settings() -> None:
    """So a client reads a file and sends what it says; the kernel reads none."""
    plain = yaml.safe_load((FOLDER / "remus100.yaml").read_text("utf-8"))
    settings = make_settings(FossenSettings, {"vehicle": plain, "integrator": "lie"})
    assert settings is not None
    assert settings.vehicle == read_bundled("remus100")
    with pytest.raises(ArgumentError, match="mass"):
        make_settings(FossenSettings, {"vehicle": {**plain, "mass": {"value": "heavy", "unit": "kg", "source": "x"}}})
