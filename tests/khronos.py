"""The Khronos Group's own validator of glTF."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent

NEEDS_VALIDATOR = pytest.mark.skipif(
    not (shutil.which("node") and (ROOT / "node_modules/gltf-validator").exists()),
    reason="Khronos' validator comes with `npm ci`",
)

_VALIDATE = """
const validator = require('gltf-validator');
const bytes = new Uint8Array(require('fs').readFileSync(process.argv[1]));
validator.validateBytes(bytes, {maxIssues: 0}).then(report => console.log(JSON.stringify(report.issues)));
"""


def issues_of(file: Path) -> dict[str, Any]:
    """Return what the validator finds in a file."""
    run = subprocess.run(["node", "-e", _VALIDATE, str(file)], cwd=ROOT, capture_output=True, text=True, check=True)
    return json.loads(run.stdout)
