# SPDX-License-Identifier: MIT
"""Study: what one filter pass with sensitivities costs, with the core built for levels of x86-64.

    python -m benchmarks.studies.levels                   # CXX=... chooses the compiler

builds the core per level into build/levels/, and times the first pass of an identification of the model ship
(least of several, CPU time) in turn with the lowest level's.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Sequence
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import command

FLAGS = {
    "x86-64": "",
    "x86-64-v2": "-march=x86-64-v2 -ffp-contract=off",
    "x86-64-v3": "-march=x86-64-v3 -ffp-contract=off",
    "x86-64-v3 with FMA": "-march=x86-64-v3 -ffp-contract=fast",
}
ROUNDS, REPEATS = 4, 10
COMPARED = ("cost", "gradient", "information", "innovation", "state")


class Reached(Exception):  # noqa: N818 - no error
    """The first pass was caught."""


def built(level: str) -> Path:
    """The extension for a level."""
    compiler = Path(os.environ.get("CXX", "c++"))
    folder = command.ROOT / "build" / "levels" / f"{compiler.parent.name}-{level.replace(' ', '-')}"
    nanobind = [sys.executable, "-m", "nanobind", "--cmake_dir"]
    where = subprocess.run(nanobind, capture_output=True, text=True, check=True).stdout.strip()
    options = [f"-DCMAKE_CXX_FLAGS={FLAGS[level]}", f"-DPython_EXECUTABLE={sys.executable}"]
    options += ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", f"-Dnanobind_DIR={where}"]
    source = command.ROOT / "core" / "bindings"
    subprocess.run(["cmake", "-S", source, "-B", folder, *options], check=True, capture_output=True)
    subprocess.run(["cmake", "--build", folder], check=True, capture_output=True)
    return next(folder.glob("_core*.so"))


def timed(extension: str) -> tuple[float, dict[str, Any]]:
    """CPU time [s] of the first pass with this extension in the place of the installed one, and its results."""
    loader = ExtensionFileLoader("seatrial._core", extension)
    core: Any = module_from_spec(spec_from_loader(loader.name, loader))  # type: ignore[arg-type]
    loader.exec_module(core)
    sys.modules["seatrial._core"] = core
    import seatrial  # noqa: PLC0415 - after its core
    from seatrial.demo import bundled_data  # noqa: PLC0415

    calls, run = [], core.innovations

    def first(*given: Any, **named: Any) -> None:  # noqa: ANN401
        calls.append((given, named))
        raise Reached

    seatrial._core = core
    core.innovations = first
    ship = bundled_data() / "cse1"
    vehicle = seatrial.load_vehicle(ship / "vehicle.yaml")
    recording = seatrial.read(ship / "mcap" / "CSE1_data_random_run1.mcap", vehicle)
    with contextlib.suppress(Reached):
        seatrial.identify([recording], vehicle)
    times = []
    for _ in range(REPEATS):
        begin = time.thread_time()
        found = run(*calls[0][0], **calls[0][1])
        times.append(time.thread_time() - begin)
    return min(times), {name: np.asarray(getattr(found, name)) for name in COMPARED}


def measured(extension: Path) -> tuple[float, dict[str, Any]]:
    """The same in a process of its own."""
    ask = [sys.executable, "-m", "benchmarks.studies.levels", "--of", str(extension)]
    done = subprocess.run(ask, capture_output=True, check=True, cwd=command.ROOT)
    return pickle.loads(done.stdout)  # type: ignore[no-any-return]


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("studies.levels", __doc__)
    parser.add_argument("--of", help="pickle of one extension's time and results")
    args = parser.parse_args(arguments)
    if args.of:
        sys.stdout.buffer.write(pickle.dumps(timed(args.of)))
        return
    extensions = {level: built(level) for level in FLAGS}
    rounds = [{level: measured(path) for level, path in extensions.items()} for _ in range(ROUNDS)]
    lowest = next(iter(FLAGS))
    print("| core for | pass [ms] | gain | largest relative difference |\n|---|---|---|---|")
    for level in FLAGS:
        gain = np.median([1 - r[level][0] / r[lowest][0] for r in rounds])
        apart = max(
            float(np.nanmax(np.abs(value - rounds[0][lowest][1][name])) / np.nanmax(np.abs(value)))
            for name, value in rounds[0][level][1].items()
        )
        least = 1e3 * min(r[level][0] for r in rounds)
        print(f"| {level} | {least:.1f} | {100 * gain:.0f} % | {apart:.1g} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
