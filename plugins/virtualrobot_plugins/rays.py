"""The plugin `rays`: the bundled ray casters."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.ray_casters.bullet import BulletCaster
from virtualrobot_plugins.ray_casters.embree import EmbreeCaster
from virtualrobot_plugins.ray_casters.reference import ReferenceCaster

api_version = "1.0"

PATIENT_SECONDS = 60.0
"""Deadline of a cast (s) by a component that is there to compare with, and not for speed."""


@hookimpl
def virtualrobot_register_ray_casters(register: Register) -> None:
    """Offer the ray casters; those that hold the GIL as long as they cast run in processes of their own."""
    register("bullet", BulletCaster, deadline_seconds=PATIENT_SECONDS)
    register("embree", EmbreeCaster, isolation=Isolation.IN_PROCESS)
    register("reference", ReferenceCaster, deadline_seconds=PATIENT_SECONDS)
