# SPDX-License-Identifier: MIT
"""Wheels for Linux on x86-64 and aarch64, each from this machine: zig is the compiler, auditwheel the judge.

python tools/wheels.py [--arch aarch64] [--python 3.12] [--out dist]

A Python only gives its headers, which are the same for both machines. Zig links against the symbols of
glibc 2.28 and puts libc++ into the extension; auditwheel finds the oldest glibc that a wheel runs with.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "wheels"
GLIBC = "2.28"
MACHINES = ("x86_64", "aarch64")
PYTHONS = ("3.10", "3.11", "3.12")  # the last one's wheel is for later ones, too (stable ABI)


def interpreter(version: str) -> str:
    """A Python of this version, from PATH or of pyenv. Exits where there is none."""
    of_pyenv = sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python{version}"))
    for found in (shutil.which(f"python{version}"), *of_pyenv):
        if (
            found
            and subprocess.run([found, "-c", ""], capture_output=True, check=False).returncode == 0
        ):
            return str(found)
    raise SystemExit(f"python{version} is missing: put it on PATH, or choose others with --python")


def compiler(machine: str) -> Path:
    """Folder with zig's programs for a machine under the names of a C++ compiler's."""
    import ziglang  # noqa: PLC0415 - of the extra `wheels`

    zig = Path(ziglang.__file__).parent / "zig"
    folder = BUILD / f"zig-{machine}"
    folder.mkdir(parents=True, exist_ok=True)
    target = f"-target {machine}-linux-gnu.{GLIBC}"
    for name, command in {"c++": f"c++ {target}", "ar": "ar", "ranlib": "ranlib"}.items():
        (folder / name).write_text(f'#!/bin/sh\nexec "{zig}" {command} "$@"\n')
        (folder / name).chmod(0o755)
    return folder


def build(machine: str, version: str) -> Path:
    """A wheel that states no more than "linux", built with the declared dependencies alone."""
    tools, name = compiler(machine), f"{machine}-{version}"
    raw = BUILD / f"raw-{name}"
    shutil.rmtree(raw, ignore_errors=True)
    settings = {
        "CXX": f"{tools}/c++",
        "CMAKE_ARGS": f"-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR={machine} "
        f"-DCMAKE_AR={tools}/ar -DCMAKE_RANLIB={tools}/ranlib",
        "SETUPTOOLS_EXT_SUFFIX": f".cpython-{version.replace('.', '')}-{machine}-linux-gnu.so",
        "SKBUILD_BUILD_DIR": str(BUILD / name),
        "_PYTHON_HOST_PLATFORM": f"linux-{machine}",
    }
    command = [interpreter(version), "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check"]
    command += ["--no-deps", "--wheel-dir", str(raw), str(ROOT)]
    subprocess.run(command, check=True, env=os.environ | settings)
    return next(raw.glob("*.whl"))


def audited(raw: Path, out: Path) -> Path:
    """The wheel under the name of the oldest glibc that it runs with. Exits where that is newer than GLIBC."""
    command = [sys.executable, "-m", "auditwheel", "repair", "--only-plat", str(raw)]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*command, "--wheel-dir", folder], check=True, capture_output=True)
        (found,) = Path(folder).iterdir()
        needs = re.search(r"manylinux_2_(\d+)_", found.name)
        if needs is None or int(needs[1]) > int(GLIBC.partition(".")[2]):
            raise SystemExit(f"{found.name}: needs a newer system than glibc {GLIBC}")
        out.mkdir(parents=True, exist_ok=True)
        return Path(shutil.move(found, out / found.name))


def wheels(machines: list[str], pythons: list[str], out: Path) -> Iterator[Path]:
    """All of them, one after the other."""
    for machine in machines:
        for version in pythons:
            yield audited(build(machine, version), out)


def main() -> None:
    """Build the chosen wheels, and print their sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arch", nargs="+", choices=MACHINES, default=MACHINES)
    parser.add_argument("--python", nargs="+", choices=PYTHONS, default=PYTHONS)
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder (default: dist)")
    args = parser.parse_args()
    for wheel in wheels(args.arch, args.python, args.out):
        print(f"{wheel.name}  {wheel.stat().st_size / 1e6:.2f} MB", flush=True)


if __name__ == "__main__":
    main()
