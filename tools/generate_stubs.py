"""Write the Python stubs of the contract: `python tools/generate_stubs.py [directory]`.

The proto path is the Python path, so proto/virtualrobot/v1/robot.proto becomes virtualrobot/v1/robot_pb2.py,
robot_pb2.pyi and robot_pb2_grpc.py, and the imports between them work unchanged.

The generator lives in an environment of its own (below build/, made when it is missing): it is the oldest one that we
support, and would hold back protobuf and gRPC everywhere else.
"""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROTO = ROOT / "proto"
CLIENT = ROOT / "clients" / "python"
STUBS = Path("virtualrobot") / "v1"
GENERATED = ("*_pb2.py", "*_pb2.pyi", "*_pb2_grpc.py")

# Stubs refuse a runtime older than their generator, and a protobuf runtime takes generated code of its own major
# version and of the one before. The first generator with protobuf 6 (6.30) thus makes protobuf 6.30 to 7.x right; newer
# ones would shut out users whose other packages don't allow protobuf 7 yet. The lower bounds in pyproject.toml follow.
GENERATOR = "1.72.2"
# grpcio-tools asks for any setuptools; pinned with it so that the same command gives the same stubs next year.
REQUIREMENTS = (f"grpcio-tools=={GENERATOR}", f"grpcio=={GENERATOR}", "protobuf==6.33.6", "setuptools==80.9.0")


def generator_python() -> Path:
    """Return the Python of the generator's environment, made first when it is missing (some 10 seconds, once)."""
    home = ROOT / "build" / f"stub-generator-{GENERATOR}-py{sys.version_info.major}{sys.version_info.minor}"
    python = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    complete = home / "complete"
    if not complete.exists():
        print(f"setting up grpcio-tools {GENERATOR} ... (once)", flush=True)
        venv.create(home, clear=True, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *REQUIREMENTS], check=True)
        complete.touch()
    return python


def generate(output: Path) -> list[Path]:
    """Write the stubs of every proto file below `output` and remove those whose proto file is gone.

    Returns:
        The generated files, sorted.

    Raises:
        subprocess.CalledProcessError: protoc refused a proto file (it has printed file, line and reason), or the
            generator could not be installed.
    """
    (output / STUBS).mkdir(parents=True, exist_ok=True)
    for pattern in GENERATED:
        for old in (output / STUBS).glob(pattern):
            old.unlink()
    targets = [f"--{kind}_out={output}" for kind in ("python", "pyi", "grpc_python")]
    sources = sorted(str(path.relative_to(PROTO)) for path in PROTO.rglob("*.proto"))
    # The generator adds the well-known types (google/protobuf/*.proto) itself.
    command = [generator_python(), "-m", "grpc_tools.protoc", f"--proto_path={PROTO}", *targets, *sources]
    subprocess.run(command, check=True)
    return sorted(path for pattern in GENERATED for path in (output / STUBS).glob(pattern))


def main() -> None:
    """Generate into the client library, or into the directory that the command line names."""
    output = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else CLIENT
    try:
        written = generate(output)
    except subprocess.CalledProcessError as error:
        sys.exit(f"no stubs: {error.cmd[2]} ended with status {error.returncode}")
    print(f"{len(written)} files written below {output / STUBS}")


if __name__ == "__main__":
    main()
