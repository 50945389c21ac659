"""The plugin `sensor_models`: what range sensors say of what their rays truly hit."""

from virtualrobot_sdk.hookspecs import Register, hookimpl
from virtualrobot_sdk.registration import Isolation

from virtualrobot_plugins.sensor_models.ideal import Ideal
from virtualrobot_plugins.sensor_models.infrared import Infrared, InfraredSettings
from virtualrobot_plugins.sensor_models.laser import Laser, LaserSettings
from virtualrobot_plugins.sensor_models.sonar import Sonar, SonarSettings
from virtualrobot_plugins.sensor_models.ultrasonic import Ultrasonic, UltrasonicSettings

api_version = "1.0"


@hookimpl
def virtualrobot_register_sensor_models(register: Register) -> None:
    """Offer the models; a scan takes them a millisecond of NumPy, so they may run in the kernel's process."""
    register("ideal", Ideal, isolation=Isolation.IN_PROCESS)
    register("infrared", Infrared, InfraredSettings, isolation=Isolation.IN_PROCESS)
    register("laser", Laser, LaserSettings, isolation=Isolation.IN_PROCESS)
    register("sonar", Sonar, SonarSettings, isolation=Isolation.IN_PROCESS)
    register("ultrasonic", Ultrasonic, UltrasonicSettings, isolation=Isolation.IN_PROCESS)
