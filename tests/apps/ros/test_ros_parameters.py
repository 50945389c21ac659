"""Parameters by rosapi, with roslibpy."""

from __future__ import annotations

import pytest
import roslibpy
from roslibpy.core import ServiceException
from virtualrobot import Client
from virtualrobot_apps.bridges.ros.parameters import ParameterError, Parameters

from tests.apps.ros.bridges import bridge, roslibpy_client, told


def test_clients_share_parameters(client: Client) -> None:
    with bridge(client) as (url, _), roslibpy_client(url) as ros:
        roslibpy.Param(ros, "/arm/speed").set(0.5)
        roslibpy.Param(ros, "arm/names").set(["a", "b"])
        assert roslibpy.Param(ros, "/arm").get() == {"speed": 0.5, "names": ["a", "b"]}
        assert roslibpy.Param(ros, "/use_sim_time").get() is True
        assert told(ros.get_params()) == ["/arm/names", "/arm/speed", "/use_sim_time"]
        roslibpy.Param(ros, "/arm/speed").delete()
        with pytest.raises(ServiceException, match="there is no parameter '/arm/speed'"):
            roslibpy.Param(ros, "/arm/speed").get()


def test_names_and_spaces_exclude_each_other() -> None:
    parameters = Parameters()
    parameters.set("/a", 1)
    parameters.set("/a/b", {"c": {"d": 2}})
    assert parameters.names() == ["/a/b/c/d", "/use_sim_time"]
    parameters.set("/a", 3)
    assert parameters.get("/a") == 3
    with pytest.raises(ParameterError, match="no name of a parameter"):
        parameters.set("/a b", 1)
