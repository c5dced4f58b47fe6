# SPDX-License-Identifier: MIT
"""Gate: what an installation costs: size, time to the first model, start; without a compiler.

python -m benchmarks.install dist/*.whl      # the wheels of this Python are installed, of all the size is printed

The environment is empty, and its programs are the only ones on PATH. Downloads are from pip's cache where it
has them.
"""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from packaging.tags import sys_tags
from packaging.utils import parse_wheel_filename

from benchmarks.harness import command

RUN = "mcap/CSE1_data_run1.mcap"  # the shortest recording of the model ship
STARTS = 5
LARGEST = 8  # folders that are listed
MB = 1e6  # [bytes]


@dataclass(frozen=True)
class Environment:
    """A virtual environment of its own."""

    folder: Path

    @property
    def packages(self) -> Path:
        """Where pip installs to."""
        return next(self.folder.glob("lib/python*/site-packages"))

    def run(self, program: str, *arguments: str | Path) -> float:
        """Wall time [s] of one of its programs; nothing else is on PATH. Raises CalledProcessError."""
        begin = time.perf_counter()
        subprocess.run(
            [self.folder / "bin" / program, *arguments], cwd=self.folder, check=True, text=True,
            capture_output=True, env={"PATH": str(self.folder / "bin"), "HOME": os.environ["HOME"]},
        )  # fmt: skip
        return time.perf_counter() - begin

    def sizes(self) -> dict[str, int]:
        """Bytes by entry of site-packages, without pip, compiled files and metadata."""
        found = {}
        for entry in self.packages.iterdir():
            if not entry.name.startswith(("pip", "setuptools", "_distutils", "distutils")):
                files = [entry] if entry.is_file() else entry.rglob("*")
                found[entry.name] = sum(
                    f.stat().st_size for f in files if f.is_file() and f.suffix != ".pyc"
                )
        return found


def installed(wheel: str, folder: Path) -> tuple[Environment, float]:
    """An environment with this wheel (extras in brackets behind it) and what it depends on, and the seconds."""
    venv.create(folder, with_pip=True)
    environment = Environment(folder)
    for compiler in ("cc", "c++", "gcc", "g++", "clang", "cmake"):
        assert shutil.which(compiler, path=str(folder / "bin")) is None
    pip = (
        "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:",
    )  # fmt: skip
    return environment, environment.run("python", *pip, wheel)


def first_model(environment: Environment) -> float:
    """Seconds to a model of the model ship from one of the recordings that the wheel brings."""
    ship = environment.packages / "seatrial" / "data" / "cse1"
    out = environment.folder / "model.yaml"
    return environment.run(
        "seatrial", "identify", ship / RUN, "--vehicle", ship / "vehicle.yaml", "-o", out
    )


def start(environment: Environment) -> float:
    """CPU time [s] of `import seatrial` with its core beyond an empty Python; least of several."""
    times = {"pass": 9.0, "import seatrial; seatrial.identify": 9.0}
    for code in list(times) * STARTS:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        environment.run("python", "-c", code)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        times[code] = min(times[code], spent)
    empty, full = times.values()
    return full - empty


def fits(wheel: Path) -> bool:
    """Whether pip installs it into this Python here."""
    return not parse_wheel_filename(wheel.name)[3].isdisjoint(sys_tags())


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("install", __doc__)
    parser.add_argument("wheels", type=Path, nargs="+")
    wheels = parser.parse_args(arguments).wheels
    print("| wheel | MB |\n|---|---|")
    for wheel in wheels:
        print(f"| `{wheel.name}` | {wheel.stat().st_size / MB:.2f} |")
    for wheel in filter(fits, wheels):
        with tempfile.TemporaryDirectory() as folder:
            environment, seconds = installed(str(wheel.resolve()), Path(folder) / "venv")
            sizes = environment.sizes()
            print(f"\n`{wheel.name}`\n\n| figure | value |\n|---|---|")
            print(f"| `pip install` | {seconds:.1f} s |")
            print(
                f"| `seatrial identify` of a 4-minute recording | {first_model(environment):.1f} s |"
            )
            print(f"| `import seatrial` | {start(environment):.3f} s |")
            print(f"| installed | {sum(sizes.values()) / MB:.0f} MB |", flush=True)
            for name in sorted(sizes, key=lambda n: -sizes[n])[:LARGEST]:
                print(f"| of it `{name}` | {sizes[name] / MB:.1f} MB |")


if __name__ == "__main__":
    main(sys.argv[1:])
