"""Importers of files that the kernel does not read itself.

Each translates bytes to bytes and imports the library that it needs only when it is asked.
"""

from virtualrobot_sdk.hookspecs import RegisterImporter

from virtualrobot_plugins.importers.dxf.importer import DxfImporter, DxfSettings
from virtualrobot_plugins.importers.ply import OffImporter, PlyImporter
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.step import StepImporter, StepSettings
from virtualrobot_plugins.importers.threemf import ThreeMfImporter
from virtualrobot_plugins.importers.vrml.importer import VrmlImporter

HEAVY_SECONDS = 300.0
"""How long a STEP or DXF file of a whole plant may take."""


def register_all(register: RegisterImporter) -> None:
    """Register the importers of meshes, drawings and SDFormat."""
    register("dxf", DxfImporter, (".dxf",), DxfSettings, deadline_seconds=HEAVY_SECONDS)
    register("off", OffImporter, (".off",))
    register("ply", PlyImporter, (".ply",))
    register("sdf", SdfImporter, (".sdf", ".world"))
    register("step", StepImporter, (".step", ".stp"), StepSettings, deadline_seconds=HEAVY_SECONDS)
    register("threemf", ThreeMfImporter, (".3mf",))
    register("vrml", VrmlImporter, (".wrl", ".wrz"))
