"""Build the picking program of a language: `python tools/build_client.py cpp|go|java FOLDER`, and print how it is run.

Stubs are made of the contract by the language's generator, compiled, and linked with the program, all below FOLDER.
What of C++ and Java is there and newer than its source stays. `tools/install_toolchains.sh` brings compilers and
libraries.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CLIENTS = ROOT / "clients"
CONTRACT = ROOT / "proto"
GOOGLE = CLIENTS / "node" / "proto"
"""Where the messages of refusals are, google.rpc."""

SERVICES = ("kernel", "scene", "sensor", "motion", "collision")
"""Services that the program calls."""

JARS = (
    *("grpc-api", "grpc-context", "grpc-core", "grpc-netty", "grpc-protobuf", "grpc-protobuf-lite", "grpc-stub"),
    *("netty-buffer", "netty-codec", "netty-codec-http", "netty-codec-http2", "netty-common", "netty-handler"),
    *("netty-handler-proxy", "netty-resolver", "netty-transport"),
    *("protobuf", "guava", "perfmark-api", "geronimo-annotation-1.3-spec"),
)
"""Libraries of the Java program, in Debian's folder of them."""


def run(*command: str | Path, **environment: str) -> str:
    """Run a command and return what it prints; end with its words when it fails."""
    done = subprocess.run(list(map(str, command)), env=os.environ | environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stdout}{done.stderr}")
    return done.stdout


def protoc(folders: Sequence[Path], *options: str | Path) -> None:
    """Make stubs of all proto files below `folders`."""
    files = [file.relative_to(folder) for folder in folders for file in sorted(folder.rglob("*.proto"))]
    run("protoc", *(f"--proto_path={folder}" for folder in folders), *options, *files)


def is_fresh(made: Path, sources: Sequence[Path]) -> bool:
    """Return whether a file is newer than all that it is made of."""
    return made.exists() and made.stat().st_mtime > max(source.stat().st_mtime for source in sources)


def needed(names: Iterable[str]) -> set[str]:
    """Return the names of files of the contract, with those that they import."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        if (name := waiting.pop()) not in found:
            found.add(name)
            text = (CONTRACT / "virtualrobot" / "v1" / f"{name}.proto").read_text("utf-8")
            waiting += re.findall(r'^import "virtualrobot/v1/(\w+)\.proto";', text, re.MULTILINE)
    return found


def included(source: Path) -> str:
    """Return the lines that make a generated C++ file part of another one: two of its names are those of all others."""
    own = source.name.replace(".", "_")
    names = ("schemas", "file_default_instances")
    return "".join(
        (
            *(f"#define {name} {name}_{own}\n" for name in names),
            f'#include "{source}"\n',
            *(f"#undef {name}\n" for name in names),
        )
    )


def cpp(folder: Path) -> list[str]:
    """Build the C++ program; only the messages and services that it needs are compiled."""
    stubs, objects, program = folder / "stubs", folder / "objects", folder / "pick"
    for each in (stubs, objects):
        each.mkdir(exist_ok=True)
    fresh = stubs / "made"
    if not is_fresh(fresh, [*CONTRACT.rglob("*.proto")]):
        plugin = shutil.which("grpc_cpp_plugin")
        options = (f"--cpp_out={stubs}", f"--grpc_out={stubs}", f"--plugin=protoc-gen-grpc={plugin}")
        protoc((CONTRACT, GOOGLE), *options)
        fresh.touch()
    messages = [*(f"virtualrobot/v1/{name}" for name in sorted(needed(SERVICES))), "google/rpc/status"]
    compiled = [stubs / f"{name}.pb.cc" for name in (*messages, "google/rpc/error_details")]
    compiled += [stubs / f"virtualrobot/v1/{service}.grpc.pb.cc" for service in SERVICES]
    flags = ("g++", "-std=c++17", "-O0", f"-I{stubs}")
    # Headers take most of the time: files are compiled together, in as many parts as there are cores.
    parts = os.cpu_count() or 1
    together = [compiled[first::parts] for first in range(parts)]

    def compile_some(number: int) -> Path:
        source, made = objects / f"{number}.cc", objects / f"{number}.o"
        if not is_fresh(made, together[number]):
            source.write_text("".join(map(included, together[number])), "utf-8")
            run(*flags, "-c", source, "-o", made)
        return made

    with ThreadPoolExecutor() as pool:
        linked = list(pool.map(compile_some, range(len(together))))
    main = CLIENTS / "cpp" / "pick.cpp"
    if not is_fresh(program, [main, *linked]):
        libraries = run("pkg-config", "--libs", "grpc++", "protobuf").split()
        run(*flags, "-Wall", "-Wextra", "-Werror", main, *linked, "-o", program, *libraries)
    return [str(program)]


def go(folder: Path) -> list[str]:
    """Build the Go program against Debian's packages, without a module of its own."""
    stubs, program, generator = folder / "src", folder / "pick", folder / "protoc-gen-go"
    stubs.mkdir(exist_ok=True)
    environment = {"GO111MODULE": "off", "GOPATH": f"{folder}{os.pathsep}/usr/share/gocode", "GOFLAGS": "-mod="}
    # Debian's own protoc-gen-go is one from before optional fields.
    run("go", "build", "-o", generator, "google.golang.org/protobuf/cmd/protoc-gen-go", **environment)
    names = ",".join(f"M{file.relative_to(CONTRACT)}=virtualrobot/v1" for file in sorted(CONTRACT.rglob("*.proto")))
    options = [
        f"--{kind}_{part}"
        for kind in ("go", "go-grpc")
        for part in (f"out={stubs}", f"opt=paths=source_relative,{names}")
    ]
    protoc((CONTRACT,), f"--plugin={generator}", *options)
    run("go", "build", "-o", program, CLIENTS / "go" / "pick.go", **environment)
    return [str(program)]


def java(folder: Path) -> list[str]:
    """Build the Java program; the copy of the contract says that each message is a class of its own.

    Only the classes that it needs, and those that these need, are compiled.
    """
    contract, stubs, classes = folder / "proto", folder / "stubs", folder / "classes"
    main = CLIENTS / "java" / "Pick.java"
    libraries = os.pathsep.join(f"/usr/share/java/{jar}.jar" for jar in JARS)
    if not is_fresh(classes / "Pick.class", [main, *CONTRACT.rglob("*.proto"), *GOOGLE.rglob("*.proto")]):
        for each in (contract, stubs, classes):
            shutil.rmtree(each, ignore_errors=True)
            each.mkdir()
        for file in sorted(CONTRACT.rglob("*.proto")):
            copy = contract / file.relative_to(CONTRACT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            package = "package virtualrobot.v1;"
            options = f'option java_multiple_files = true;\noption java_outer_classname = "{file.stem.title()}Proto";'
            copy.write_text(file.read_text("utf-8").replace(package, f"{package}\n{options}", 1), "utf-8")
        plugin = shutil.which("grpc_java_plugin")
        options = (f"--java_out={stubs}", f"--grpc-java_out={stubs}", f"--plugin=protoc-gen-grpc-java={plugin}")
        protoc((contract, GOOGLE), *options)
        run("javac", "-nowarn", "-proc:none", "-cp", libraries, "-sourcepath", stubs, "-d", classes, main)
    return ["java", "-cp", f"{classes}{os.pathsep}{libraries}", "Pick"]


LANGUAGES: dict[str, Callable[[Path], list[str]]] = {"cpp": cpp, "go": go, "java": java}

if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in LANGUAGES:
        sys.exit(f"say a language of {', '.join(LANGUAGES)} and a folder: build_client.py go build/go")
    target = Path(sys.argv[2]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    print(*LANGUAGES[sys.argv[1]](target))
