# SPDX-License-Identifier: MIT
"""The C header, compiled and run: the core's S7, here and on aarch64; it can be read and can't be misused."""

import re

import numpy as np
import pytest
from export_tools import BOATS, boat, drive, program, run, trace_states, truth

from seatrial.export import export

pytestmark = pytest.mark.system
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wshadow", "-Wconversion")
MAIN = """
#include <stdio.h>
#include "boat.h"
int main(void) {{
  static boat_boat own;
  double t, command[BOAT_COMMANDS];
  int i;
  boat_reset(&own);
  while (scanf("%lf", &t) == 1) {{
    if (!boat_step(&own, t - own.time)) return 1;
    for (i = 0; i < BOAT_STATES; ++i) printf("%.17g ", own.x[i]);
    printf("\\n");
    for (i = 0; i < BOAT_COMMANDS; ++i) if (scanf("%lf", &command[i]) != 1) return 2;
    {scales}
    if (!boat_command(&own, command)) return 3;
  }}
  return 0;
}}
"""


def build(folder, name, compiler="cc", *more):
    model = boat(name)
    export(model, "c", folder / "boat.h")
    scales = "".join(
        f'if (scanf("%lf", &own.scale[{i}]) != 1) return 4;'
        for i, _ in enumerate(model.vehicle.scales)
    )
    (folder / "main.c").write_text(MAIN.format(scales=scales))
    run(compiler, *STRICT, "-O2", *more, "-o", folder / "boat", folder / "main.c", "-lm")
    return folder / "boat"


def rows_of(name, seconds=np.inf) -> str:
    own = drive(name).first(seconds)
    return "\n".join(
        " ".join(f"{x:.17g}" for x in row)
        for row in np.column_stack([own.t, own.commands, own.scales])
    )


@pytest.mark.parametrize("name", BOATS)
def test_it_moves_the_boat_along_s7_as_the_core_does(tmp_path, name):
    program("cc")
    shown = run(build(tmp_path, name), stdin=rows_of(name))
    states = np.array([line.split() for line in shown.splitlines()], dtype=float)
    assert states.shape == (len(drive(name).t), 6)
    assert (
        np.abs(truth(name)[:, 3:]).max(axis=0).min() > 0.01
    )  # it does go somewhere, on every axis
    np.testing.assert_allclose(states, truth(name), rtol=0, atol=1e-9)


def test_on_aarch64_it_says_the_same(tmp_path):
    program("aarch64-linux-gnu-gcc", "qemu-aarch64")
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    given = rows_of("ship", 60.0)
    exact = "-ffp-contract=off"
    native = run(build(here, "ship", "cc", exact), stdin=given)
    other = build(there, "ship", "aarch64-linux-gnu-gcc", "-static", exact)
    found = run("qemu-aarch64", other, stdin=given)
    states = [
        np.array([line.split() for line in s.splitlines()], dtype=float) for s in (native, found)
    ]
    np.testing.assert_allclose(
        states[1], states[0], rtol=0, atol=1e-12
    )  # their libm may differ in the last bit


def test_it_is_c_plus_plus_too_and_bears_the_sanitizers(tmp_path):
    program("c++")
    built = build(
        tmp_path, "ship", "cc", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"
    )
    run(built, stdin=rows_of("ship", 30.0))
    (tmp_path / "main.cpp").write_text((tmp_path / "main.c").read_text())
    run(
        "c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only",
        tmp_path / "main.cpp",
    )  # fmt: skip


def test_commands_that_are_no_numbers_times_that_go_back_and_full_queues_are_refused(tmp_path):
    program("cc")
    export(boat("always_forward"), "c", tmp_path / "boat.h")
    (tmp_path / "main.c").write_text(
        '#include <stdio.h>\n#include "boat.h"\nint main(void) { static boat_boat b, before; int n = 0;\n'
        "  const double good[3] = {0.5, 0.0, 0.0}, bad[3] = {0.5, NAN, 0.0}, worse[3] = {0.0, 0.0, INFINITY};\n"
        "  boat_reset(&b); boat_command(&b, good); boat_step(&b, 0.5); before = b;\n"
        '  printf("%d %d ", boat_command(&b, bad), boat_command(&b, worse));\n'
        '  printf("%d %d ", boat_step(&b, -0.1), boat_step(&b, NAN));\n'
        '  printf("%d ", memcmp(&b, &before, sizeof b));\n'
        "  while (boat_command(&b, good)) ++n;\n"
        '  printf("%d %d ", n == BOAT_PENDING, boat_step(&b, 0.1));\n'
        '  printf("%d ", boat_command(&b, good)); b.x[BOAT_U] = 1e12; printf("%d", boat_step(&b, 1.0)); return 0; }\n'
    )
    run("cc", *STRICT, "-o", tmp_path / "boat", tmp_path / "main.c", "-lm")
    assert run(tmp_path / "boat").split() == ["0", "0", "0", "0", "0", "1", "1", "1", "0"]


@pytest.mark.parametrize("name", ["always_forward", "right_down"])
def test_the_cores_two_ways_agree_up_to_their_integrator(name):
    """A recording's repeated commands break no step, the plant's do: that is all the difference."""
    np.testing.assert_allclose(
        truth(name), trace_states(boat(name), drive(name)), rtol=0, atol=1e-7
    )


def test_every_number_of_the_model_is_in_the_header_with_its_error_and_unit(tmp_path):
    model = boat("always_forward")
    export(model, "c", tmp_path / "my-boat.h")
    text = (tmp_path / "my-boat.h").read_text()
    found = dict(re.findall(r"#define MY_BOAT_(\w+)\s+\((\S+)\)\s+/\* ", text))
    assert {name: float(value) for name, value in found.items()} == {
        **model.values, **dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    }  # fmt: skip
    assert re.search(r"#define MY_BOAT_X_uu +\(-1\.74\) +/\* \+- 0\.17 +\[1/m\] \*/", text)
    for term in ("v * r", "MY_BOAT_X_u * u", "MY_BOAT_X_uu * fabs(u) * u", "MY_BOAT_X_F * F_u"):
        assert f"g[0] += {term};" in text
