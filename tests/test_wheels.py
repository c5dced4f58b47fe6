# SPDX-License-Identifier: MIT
"""The source distribution and the wheels, as a user gets them."""

import json
import os
import sys
import tarfile

import numpy as np
import pytest
from conftest import CSE1, ROOT
from cpp_tools import needs
from wheel_tools import VERSION, emulated, packages_for_aarch64, python_for_aarch64, quiet

from benchmarks import install

sys.path.insert(0, str(ROOT / "tools"))
import wheels

FIGURES = """
import json, platform, sys, seatrial
from seatrial.evaluation.scores import scores_json
vehicle = seatrial.load_vehicle(sys.argv[2])
run = seatrial.read(sys.argv[1], vehicle)
model = seatrial.identify([run], vehicle, method="equation-error")
scores = scores_json(seatrial.validate(model, [run]))["recordings"][0]["horizons"]
errors = [s["rms"] for h in scores for s in h["scores"].values()]
print(json.dumps([platform.machine(), [*model.values.values(), *errors]]))
"""
GIVEN = (CSE1 / "csv" / "CSE1_data_random_run1.csv", CSE1 / "vehicle.yaml")


@pytest.mark.system
def test_the_source_builds_offline_and_its_wheel_gives_a_model_without_a_compiler(
    tmp_path, monkeypatch
):
    needs("c++", "ninja")
    from scikit_build_core.build import build_sdist

    monkeypatch.chdir(ROOT)
    source = tmp_path / build_sdist(str(tmp_path))
    with tarfile.open(source) as archive:
        names = archive.getnames()
        archive.extractall(tmp_path, filter="data")
    assert not [n for n in names if "/.ci/" in n or n.endswith(".so") or "/build/" in n]
    unpacked = tmp_path / names[0].partition("/")[0]
    pip = (sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check")
    # a cache of the compiler has what .ci/run compiled of the same text for the editable package; without one it is
    # compiled with little optimisation: what is packed is the same, in half of the time
    cache = {"CCACHE_BASEDIR": str(unpacked / "core"), "CCACHE_NOHASHDIR": "1"}
    quick = ("-C", "cmake.define.CMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG")
    flags = () if os.environ.get("CMAKE_CXX_COMPILER_LAUNCHER") == "ccache" else quick
    quiet(
        *pip, "--no-deps", "--no-index", "--no-build-isolation", *flags, "-w", tmp_path, unpacked,
        **{**os.environ, **cache},
    )  # fmt: skip
    (wheel,) = tmp_path.glob("*.whl")
    environment, _ = install.installed(str(wheel), tmp_path / "venv")
    assert not {"pymavlink", "lxml", "scipy"} & set(environment.sizes())
    install.first_model(environment)
    text = (environment.folder / "model.yaml").read_text()
    assert "output-error" in text and "X_u:" in text


@pytest.mark.study
def test_the_wheel_for_aarch64_gives_the_same_model_there(tmp_path):
    pytest.importorskip("ziglang", reason="make .venv/.wheels")
    needs("qemu-aarch64", "apt-get", "dpkg")
    wheel = wheels.audited(wheels.build("aarch64", VERSION), tmp_path)
    assert "manylinux_2_" in wheel.name and wheel.name.endswith("_aarch64.whl")
    root = python_for_aarch64(tmp_path / "debian")
    packages = tmp_path / "packages"
    packages_for_aarch64(wheel, packages, "numpy", "msgspec", "PyYAML", "threadpoolctl")
    there, values = json.loads(emulated(root, packages, "-c", FIGURES, *GIVEN))
    _, same = json.loads(quiet(sys.executable, "-c", FIGURES, *GIVEN))
    assert there == "aarch64"
    assert len(values) > 20
    np.testing.assert_allclose(values, same, rtol=1e-7)  # least squares of another BLAS, FMA
