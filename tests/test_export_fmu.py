# SPDX-License-Identifier: MIT
"""The Functional Mock-up Unit: FMPy finds nothing wrong with it, and moves the boat as the core does."""

import os
import shutil
import sysconfig
import zipfile
from pathlib import Path

import cli_tools
import numpy as np
import pytest
from export_tools import BOATS, boat, drive, program, run, trace_states

import seatrial
from seatrial.export import export
from seatrial.util.errors import ExportError

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
STATE = ("x", "y", "psi", "u", "v", "r")


class Unit:
    """An instance by FMPy's own wrapper of the standard's functions."""

    def __init__(self, path, folder=None):
        from fmpy.fmi2 import FMU2Slave

        self.description = fmpy.read_model_description(path)
        self.of = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = FMU2Slave(
            guid=self.description.guid, unzipDirectory=path if folder is None else fmpy.extract(path, folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="own",
        )  # fmt: skip
        self.slave.instantiate()

    def start(self, **values):
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        for name, value in values.items():
            self.slave.setReal([self.of[name]], [value])
        self.slave.exitInitializationMode()

    def get(self, names) -> list[float]:
        return self.slave.getReal([self.of[name] for name in names])

    def follow(self, names, t, rows) -> np.ndarray:
        inputs, states = [self.of[name] for name in names], np.zeros((len(t), 6))
        for i, row in enumerate(rows.tolist()):
            states[i] = self.get(STATE)
            if i + 1 < len(t):
                self.slave.setReal(inputs, row)
                self.slave.doStep(t[i], t[i + 1] - t[i])
        return states

    def end(self):
        self.slave.terminate()
        self.slave.freeInstance()


@pytest.mark.system
@pytest.mark.parametrize("name", BOATS)
def test_it_moves_the_boat_along_s7_as_the_core_does(tmp_path, name):
    program("cc")
    model, own = boat(name), drive(name)
    export(model, "fmu", tmp_path / "my-boat.fmu")
    assert validation.validate_fmu(str(tmp_path / "my-boat.fmu")) == []
    unit = Unit(tmp_path / "my-boat.fmu", tmp_path / "unit")
    unit.start()
    states = unit.follow(
        (*model.vehicle.inputs, *model.vehicle.scales), own.t, np.hstack([own.commands, own.scales])
    )
    unit.end()
    # held inputs that change are commands: it breaks where a recording does
    np.testing.assert_allclose(states, trace_states(model, own), rtol=0, atol=1e-9)


@pytest.mark.system
def test_fmpys_own_simulation_agrees(tmp_path):
    """It steps from one change of the inputs to the next: fewer breaks than commands, as on a recording."""
    program("cc")
    model, own = boat("always_forward"), drive("always_forward").first(30.0)
    export(model, "fmu", tmp_path / "boat.fmu")
    kinds = [("time", float), *((name, float) for name in model.vehicle.inputs)]
    table = np.array([(t, *row) for t, row in zip(own.t, own.commands, strict=True)], dtype=kinds)
    found = fmpy.simulate_fmu(
        str(tmp_path / "boat.fmu"), stop_time=own.t[-1], step_size=0.01, output_interval=0.01, input=table,
        output=STATE,
    )  # fmt: skip
    assert len(found) == len(own.t)
    np.testing.assert_allclose(found["time"], own.t, rtol=0, atol=1e-9)
    states = np.column_stack([found[name] for name in STATE])
    np.testing.assert_allclose(states, trace_states(model, own), rtol=0, atol=1e-9)


@pytest.mark.system
def test_it_starts_where_it_is_told_goes_back_and_starts_anew(tmp_path):
    program("cc")
    export(boat("right_down"), "fmu", tmp_path / "boat.fmu")
    unit = Unit(tmp_path / "boat.fmu", tmp_path / "unit")
    unit.start(x_start=1.0, psi_start=0.5, u_start=0.2)
    assert unit.get(STATE) == [1.0, 0.0, 0.5, 0.2, 0.0, 0.0]
    before = unit.slave.getFMUState()
    unit.slave.setReal([unit.of["F_u"]], [1.0])
    unit.slave.doStep(0.0, 1.0)
    moved = unit.get((*STATE, "F_u_given"))
    assert moved[3] != 0.2
    assert moved[-1] > 0.1
    unit.slave.setFMUState(before)
    unit.slave.setReal([unit.of["F_u"]], [1.0])
    unit.slave.doStep(0.0, 1.0)
    assert unit.get((*STATE, "F_u_given")) == moved
    unit.slave.freeFMUState(before)
    unit.slave.reset()
    unit.start()
    assert unit.get(STATE) == [0.0] * 6
    unit.end()


@pytest.mark.system
def test_a_command_that_is_no_number_is_an_error_of_the_standard(tmp_path):
    program("cc")
    export(boat("always_forward"), "fmu", tmp_path / "boat.fmu")
    unit = Unit(tmp_path / "boat.fmu", tmp_path / "unit")
    unit.start()
    unit.slave.setReal([unit.of["F_u"]], [float("nan")])
    with pytest.raises(fmpy.fmi1.FMICallException, match="status 3"):
        unit.slave.doStep(0.0, 0.1)
    unit.slave.freeInstance()


@pytest.mark.system
def test_its_source_is_strict_c_and_the_same_model_the_same_bytes(tmp_path):
    program("cc")
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        export(boat("ship"), "fmu", tmp_path / name / "boat.fmu")
    with zipfile.ZipFile(tmp_path / "one" / "boat.fmu") as archive:
        archive.extractall(tmp_path / "unit")
        first = {n: archive.read(n) for n in archive.namelist()}
    with zipfile.ZipFile(tmp_path / "two" / "boat.fmu") as archive:
        assert {n: archive.read(n) for n in archive.namelist()} == first
    strict = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only")
    for more in ((), ("-DFMI2_FUNCTION_PREFIX=boat_",)):
        run("cc", *strict, *more, tmp_path / "unit" / "sources" / "fmu.c")


@pytest.mark.system
def test_fmpy_builds_it_from_its_source_alone(tmp_path, monkeypatch):
    program("cc")
    scripts = Path(sysconfig.get_path("scripts"))  # of this environment: cmake is a requirement
    monkeypatch.setenv("PATH", f"{scripts}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("CC", "no-such-compiler")
    export(boat("bare"), "fmu", tmp_path / "boat.fmu")
    monkeypatch.delenv("CC")
    with zipfile.ZipFile(tmp_path / "boat.fmu") as archive:
        assert not [n for n in archive.namelist() if n.startswith("binaries")]
    from fmpy.build import build_platform_binary

    (tmp_path / "build").mkdir()
    build_platform_binary(
        fmpy.extract(tmp_path / "boat.fmu", tmp_path / "unit"), tmp_path / "build"
    )
    own = drive("bare").first(20.0)
    unit = Unit(tmp_path / "unit")
    unit.start()
    found = unit.follow(boat("bare").vehicle.inputs, own.t, own.commands)
    unit.end()
    np.testing.assert_allclose(found, trace_states(boat("bare"), own), rtol=0, atol=1e-9)


def binaries(path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        return [name for name in archive.namelist() if name.startswith("binaries")]


@pytest.mark.skipif(os.name != "posix", reason="a wrapper written in sh")
def test_a_compiler_may_have_options_and_a_wrapper(tmp_path, monkeypatch):
    program("cc")
    wrapper = tmp_path / "my wrapper"
    wrapper.write_text('#!/bin/sh\nexec "$@"\n')
    wrapper.chmod(0o755)
    for cc in ("cc -O1", f"'{wrapper}' cc -g", " "):
        monkeypatch.setenv("CC", cc)
        export(boat("bare"), "fmu", tmp_path / "boat.fmu")
        assert len(binaries(tmp_path / "boat.fmu")) == 1, cc


@pytest.mark.parametrize("here", [True, False], ids=["no compiler", "another platform"])
def test_a_unit_of_sources_alone_says_so_and_why(tmp_path, monkeypatch, capsys, here):
    reason = "there is no C compiler 'no-such-compiler'; install it, or set CC to another"
    monkeypatch.setenv("CC", "no-such-compiler -O2")
    if not here:
        monkeypatch.setattr("platform.machine", lambda: "riscv64")
        reason = "libraries are made on Linux x86_64"
    seatrial.save(boat("bare"), tmp_path / "model.yaml")
    out, page = tmp_path / "boat.fmu", tmp_path / "boat.json"
    given = ["export", tmp_path / "model.yaml", "--to", "fmu", "-o", out, "--json", page]
    code, said, _ = cli_tools.run(capsys, *given)
    assert code == 0 and binaries(out) == []
    about = cli_tools.documented("export", page)["about"]
    assert f"; sources only: {reason}" in about and f"wrote {out}: {about}\n" in said


def test_a_compiler_that_no_shell_reads_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "cc '")
    with pytest.raises(ExportError, match="CC is no command: cc ' "):
        export(boat("bare"), "fmu", tmp_path / "boat.fmu")


@pytest.mark.skipif(os.name != "posix", reason="a compiler written in sh")
def test_a_compiler_that_fails_is_said(tmp_path, monkeypatch):
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\necho 'cc1: out of order' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    assert shutil.which(str(broken))
    with pytest.raises(ExportError, match=r"can't compile the unit: cc1: out of order; set CC"):
        export(boat("bare"), "fmu", tmp_path / "boat.fmu")
    assert not (tmp_path / "boat.fmu").exists()
