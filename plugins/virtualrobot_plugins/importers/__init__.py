"""The plugin `importers`: files that the kernel does not read itself.

Each importer translates bytes to bytes and imports the library that it needs only when it is asked.
"""

from virtualrobot_sdk.hookspecs import RegisterImporter, hookimpl

from virtualrobot_plugins.importers.dxf.importer import DxfImporter, DxfSettings
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.solid.importer import SolidImporter
from virtualrobot_plugins.importers.step import StepImporter, StepSettings
from virtualrobot_plugins.importers.threemf import ThreeMfImporter
from virtualrobot_plugins.importers.vrml.importer import VrmlImporter
from virtualrobot_plugins.importers.xacro import Xacro, XacroSettings

api_version = "1.0"

XACRO_SECONDS = 20.0
"""Deadline for a xacro file (s); the largest take a second, and an expression in a file (`${9**9**9}`) has no end."""

SOLID_SECONDS = 60.0
"""Deadline for a modelled solid (s); most take a hundredth."""

HEAVY_SECONDS = 300.0
"""Deadline for a STEP or DXF file (s): enough for a whole plant."""


@hookimpl
def virtualrobot_register_importers(register: RegisterImporter) -> None:
    """Offer the importers, each in a process of its own: a broken file can make a native library hang or crash."""
    register("dxf", DxfImporter, (".dxf",), DxfSettings, deadline_seconds=HEAVY_SECONDS)
    register("off", OffImporter, (".off",))
    register("ply", PlyImporter, (".ply",))
    register("sdf", SdfImporter, (".sdf", ".world"))
    register("solid", SolidImporter, (".solid",), deadline_seconds=SOLID_SECONDS)
    register("step", StepImporter, (".step", ".stp"), StepSettings, deadline_seconds=HEAVY_SECONDS)
    register("threemf", ThreeMfImporter, (".3mf",))
    register("vrml", VrmlImporter, (".wrl", ".wrz"))
    # `.urdf` for the files of that name that are xacro inside; plain URDF the kernel reads itself.
    register("xacro", Xacro, (".xacro", ".urdf"), XacroSettings, deadline_seconds=XACRO_SECONDS)
