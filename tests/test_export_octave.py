# SPDX-License-Identifier: MIT
"""The MATLAB and Octave function: the core's S7 by Octave; and a parser of MATLAB's own language reads it."""

import re
import sys

import numpy as np
import pytest
from export_tools import BOATS, boat, core_states, drive, program, run
from programs import piped

from seatrial.export import export
from seatrial.util.errors import ExportError

EVERY, SECONDS = 7, 20.0  # commands, and time, of S7: Octave interprets
SCRIPT = """
rows = dlmread('rows.csv', ',');
boat = my_boat();
s = boat.reset();
states = zeros(size(rows, 1), 6);
for i = 1:size(rows, 1)
  s = boat.step(s, rows(i, 1) - s.time);
  states(i, :) = s.x';
  if columns(rows) > 1 + {inputs}
    s.scale = rows(i, {inputs} + 2:end);
  end
  s = boat.command(s, rows(i, 2:{inputs} + 1));
end
dlmwrite('states.csv', states, 'precision', '%.17g');
"""


def octave(folder, *lines) -> str:
    (folder / "script.m").write_text("1;\n" + "\n".join(lines) + "\n")
    return run("octave-cli", "--no-init-file", "--quiet", "script.m", cwd=folder)


@pytest.mark.system
@pytest.mark.parametrize("name", BOATS)
def test_it_moves_the_boat_along_s7_as_the_core_does(tmp_path, name):
    program("octave-cli")
    model, own = boat(name), drive(name).every(EVERY).first(SECONDS)
    export(model, "octave", tmp_path / "my_boat.m")
    rows = np.column_stack([own.t, own.commands, own.scales])
    np.savetxt(tmp_path / "rows.csv", rows, delimiter=",", fmt="%.17g")
    octave(tmp_path, SCRIPT.format(inputs=len(model.vehicle.inputs)))
    states = np.loadtxt(tmp_path / "states.csv", delimiter=",")
    expected = core_states(model, own)
    assert np.abs(expected[:, 3:]).max(axis=0).min() > 0.01
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-9)


@pytest.mark.system
def test_ode45_and_other_parameters_can_be_had(tmp_path):
    """A steady push reaches the closed form's top speed; with other drag another."""
    program("octave-cli")
    export(boat("always_forward"), "octave", tmp_path / "my_boat.m")
    shown = octave(
        tmp_path,
        "p = my_boat().parameters; p.N_uu = 0; p.N_ud = 0; b = my_boat(p); F = [0.8; 0; 0];",
        "[t, x] = ode45(@(t, x) b.rate(x, F), [0 60], zeros(6, 1)); printf('%.9f ', x(end, 4));",
        "p.X_uu = 2 * p.X_uu; b = my_boat(p);",
        "[t, x] = ode45(@(t, x) b.rate(x, F), [0 60], zeros(6, 1)); printf('%.9f', x(end, 4));",
    )
    tops = [(-0.2 + np.sqrt(0.2**2 + 4 * q * 0.14 * 0.8)) / (2 * q) for q in (1.74, 3.48)]
    assert [float(x) for x in shown.split()] == pytest.approx(tops, rel=1e-3)


@pytest.mark.system
@pytest.mark.parametrize(
    "call",
    ["b.command(b.reset(), [1; NaN; 0])", "b.command(b.reset(), 1)", "b.step(b.reset(), -1)"],
)
def test_what_is_no_command_or_time_is_an_error(tmp_path, call):
    program("octave-cli")
    export(boat("always_forward"), "octave", tmp_path / "my_boat.m")
    shown = octave(tmp_path, f"b = my_boat(); try, {call}; catch e, printf('%s', e.message); end")
    assert shown.startswith(
        "my_boat: a command is 3 finite" if "command" in call else "my_boat: a step is"
    )


@pytest.mark.parametrize("name", BOATS)
def test_a_parser_of_matlabs_language_reads_it(tmp_path, name):
    """MISS_HIT knows MATLAB's grammar, without what Octave adds to it; style is a matter of taste."""
    pytest.importorskip("miss_hit_core")
    export(boat(name), "octave", tmp_path / "my_boat.m")
    text = (tmp_path / "my_boat.m").read_text()
    (tmp_path / "octaves_own.m").write_text(text.replace("if ~(dt >= 0", "if !(dt >= 0"))
    assert " error: " not in matlab_errors(tmp_path / "my_boat.m")
    assert not re.search(r"[-+*/]=|\+\+|--|printf|columns\(", text.partition("\nend\n")[2])
    assert " error: " in matlab_errors(tmp_path / "octaves_own.m")


def matlab_errors(file) -> str:
    checker = (
        sys.executable,
        "-m",
        "miss_hit_core.mh_style",
        "--ignore-config",
        "--brief",
        str(file),
    )
    return piped(checker).stdout


def test_a_name_that_can_not_be_called_is_refused_with_one_that_can(tmp_path):
    with pytest.raises(ExportError, match=r"name it my_boat\.m"):
        export(boat("always_forward"), "octave", tmp_path / "my-boat.m")
    with pytest.raises(ExportError, match=r"name it boat_end\.m"):
        export(boat("always_forward"), "octave", tmp_path / "end.m")
    assert not list(tmp_path.iterdir())
