# SPDX-License-Identifier: MIT
"""A Python for aarch64 out of Debian's packages, run by qemu; nothing is installed."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

from programs import printed

VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"
SETTINGS = """\
APT::Architecture "arm64";
APT::Architectures {{ "arm64"; }};
Dir::State "{0}/state";
Dir::State::status "{0}/state/status";
Dir::Cache "{0}/cache";
"""


def quiet(*command: str | Path, **settings: str) -> str:
    return printed(*command, env=settings or None)


def python_for_aarch64(folder: Path) -> Path:
    """A root folder with this version of Python; FileNotFoundError where Debian has another version."""
    root = folder / "root"
    for each in ("state/lists/partial", "cache/archives/partial", "root"):
        (folder / each).mkdir(parents=True, exist_ok=True)
    (folder / "state" / "status").touch()
    (folder / "apt.conf").write_text(SETTINGS.format(folder))
    settings = {"APT_CONFIG": str(folder / "apt.conf"), "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    quiet("apt-get", "-qq", "update", **settings)
    wanted = (f"python{VERSION}-minimal", f"libpython{VERSION}-stdlib", "libstdc++6")
    if subprocess.run(
        ["apt-cache", "show", *wanted], env=settings, capture_output=True, check=False
    ).returncode:
        raise FileNotFoundError(wanted[0])
    quiet(
        "apt-get", "install", "-y", "-qq", "--no-install-recommends", "--download-only", *wanted, **settings,
    )  # fmt: skip
    for package in (folder / "cache" / "archives").glob("*.deb"):
        quiet("dpkg", "-x", package, root)
    return root


def packages_for_aarch64(wheel: Path, folder: Path, *others: str) -> None:
    """The wheel and what it is tested with, unpacked."""
    down = folder.parent / "downloads"
    plain = ("--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary", ":all:")
    names = [f"--platform=manylinux_2_{n}_aarch64" for n in (28, 27, 17)]
    quiet(
        sys.executable, "-m", "pip", "download", *plain, *names, "--python-version", VERSION, "--dest", down,
        *others,
    )  # fmt: skip
    for each in (wheel, *down.glob("*.whl")):
        zipfile.ZipFile(each).extractall(folder)


def emulated(root: Path, packages: Path, *arguments: str | Path) -> str:
    """What Python for aarch64 prints."""
    python = root / "usr" / "bin" / f"python{VERSION}"
    return quiet(
        shutil.which("qemu-aarch64") or "qemu-aarch64", "-L", root, python, *arguments,
        PYTHONPATH=str(packages), PYTHONHOME=str(root / "usr"), OPENBLAS_NUM_THREADS="1", PATH="/usr/bin:/bin",
    )  # fmt: skip
