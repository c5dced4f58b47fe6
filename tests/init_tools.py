# SPDX-License-Identifier: MIT
"""What tests of `seatrial init` share: recordings as tables, the vehicle proposed, and the one line of a refusal."""

from dataclasses import replace

import cli_tools
import msgspec
import pytest
from sheets import sheet

import seatrial
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices

NAMES = ("F_u", "F_v", "F_r")


def refused(capsys, *arguments):
    """The one line with which it is refused."""
    return cli_tools.refused(capsys, "init", *arguments, "-q")


def proposed(path, **choices):
    """What is proposed of a log, and the vehicle by the file of it beside the log."""
    found, file = init(path, choices=Choices(**choices)), path.with_suffix(".yaml")
    file.write_text(found.text)
    return found, seatrial.load_vehicle(file)


def tables(log, folder, **changes):
    """The log as two tables."""
    folder.mkdir()
    for name, t, values, head in (
        ("poses", log.pose_t, log.pose, changes.get("pose", "t,x,y,psi")),
        ("commands", log.command_t, log.command, changes.get("commands", "t,F_u,F_v,F_r")),
    ):
        sheet(folder / f"{name}.csv", head, t * changes.get("second", 1.0), values)
    return folder


def one_table(log, path):
    """The log as one table: a line for each pose or command, empty cells elsewhere."""
    lines = [
        (t, f"{t!r},{','.join(map(repr, p))},,,") for t, p in zip(log.pose_t.tolist(), log.pose.tolist(), strict=True)
    ]  # fmt: skip
    lines += [
        (t, f"{t!r},,,,{','.join(map(repr, c))}")
        for t, c in zip(log.command_t.tolist(), log.command.tolist(), strict=True)
    ]
    body = "\n".join(line for _, line in sorted(lines))
    path.write_text(f"t,x,y,psi,F_u,F_v,F_r\n{body}\n")
    return path


def with_papers_terms(vehicle):
    """The vehicle with the paper's terms in place of those that recordings choose."""
    assert vehicle.automatic
    return replace(vehicle, file=msgspec.structs.replace(vehicle.file, structure="mallard"))


def same_boat(found, expected):
    """Of one recording, but dead zones are sought at the forces here and at the thrusters there."""
    assert found.structure.coefficients == expected.structure.coefficients
    for name, value in expected.values.items():
        assert found.values[name] == pytest.approx(value, abs=expected.standard_errors[name]), name
    delays = [
        sum(
            value
            for name, value in zip(m.vehicle.constants.names, m.constants, strict=True)
            if name in ("latency", "lag")
        )
        for m in (found, expected)
    ]
    assert delays[0] == pytest.approx(delays[1], abs=1e-3)  # [s]
