"""The plugin `physics`: the bundled physics engines."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.physics.bullet.component import BulletPhysics, BulletSettings
from virtualrobot_plugins.physics.mujoco.component import MujocoPhysics, MujocoSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_physics_engines(register: Register) -> None:
    """Offer the engines; MuJoCo lets go of the GIL while it computes, PyBullet holds it."""
    register("bullet", BulletPhysics, BulletSettings)
    register("mujoco", MujocoPhysics, MujocoSettings, isolation=Isolation.IN_PROCESS)
