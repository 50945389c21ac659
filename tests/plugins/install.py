"""Puts plugins where a process finds them as if pip had installed them: a module, and the metadata beside it."""

from __future__ import annotations

import os
from pathlib import Path

SOURCES = Path(__file__).parent / "packages"
WRONG = (
    "raises_on_import",
    "raises_at_work",
    "hangs",
    "crashes",
    "returns_nan",
    "wrong_shape",
    "wrong_frame",
    "leaks",
)
"""The eight plugins that do what none may."""
BROKEN = (
    "hangs_on_import",
    "crashes_on_import",
    "misspelt_hook",
    "other_api",
    "no_api",
    "name_taken",
)
"""Plugins that offer nothing, each for another reason."""


def install(site: Path, *names: str) -> Path:
    """Install plugins into the folder `site` and return it; each depends on `arm_for_tests`, which comes with them."""
    for name in ("arm_for_tests", *names):
        write_package(site, name, (SOURCES / f"{name}.py").read_text("utf-8"))
    return site


def write_package(site: Path, name: str, source: str) -> Path:
    """Write a package of one module, a plugin of the same name, as pip would; return the module's file."""
    module = site / name / "__init__.py"
    module.parent.mkdir(parents=True, exist_ok=True)
    module.write_text(source, "utf-8")
    metadata = site / f"{name}-1.0.dist-info"
    metadata.mkdir(exist_ok=True)
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", "utf-8")
    if name != "arm_for_tests":
        (metadata / "entry_points.txt").write_text(f"[virtualrobot.plugins]\n{name} = {name}\n", "utf-8")
    return module


def environment(site: Path) -> dict[str, str]:
    """Return what a process needs in its environment to find what is installed in `site`."""
    others = os.environ.get("PYTHONPATH")
    return {"PYTHONPATH": os.pathsep.join([str(site), *([others] if others else [])])}
