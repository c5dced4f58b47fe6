# SPDX-License-Identifier: MIT
"""A boat that changes while it is recorded is told, and by how much; one that stays what it is, is not."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import at_length, on_request

from seatrial.boat.findings import Finding, FindingKind
from seatrial.identification.estimator import output_error
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import DisturbanceForce, load_plan, with_seed
from tests.boats.plans import driven_by, planned

PUSH = DisturbanceForce(0.04, 2.0)


def fading(recording: Recording, begin: float, end: float) -> Recording:
    """As if thrust had gone evenly from `begin` to `end` times what it is: by what the file says of commands."""
    commands = recording.commands
    share = (commands.stamps - recording.stamps[0]) / np.ptp(recording.stamps)
    factor = np.interp(share, [0.0, 1.0], [begin, end])
    told = Signal(commands.names, commands.stamps, commands.values / factor[:, None])
    return replace(recording, commands=told)


def slower(recording: Recording, rate: float) -> Recording:
    """As if the commands' clock had lost so many seconds a second from the first pose on."""
    commands, first = recording.commands, recording.stamps[0]
    stamps = commands.stamps - np.round(rate * (commands.stamps - first)).astype(np.int64)
    return replace(recording, commands=replace(commands, stamps=stamps))


def drift_of(vehicle, plan, force, names, *, thrust=(1.0, 1.0), rate=0.0) -> tuple[Finding, ...]:
    chain = [msgspec.structs.replace(group, dead_zone=None) for group in plan.plant.chain]
    plan = planned(plan, *names, plant={"unmodelled": force, "chain": chain})
    trials = {
        n: msgspec.structs.replace(t, duration=0.75 * t.duration) for n, t in plan.trials.items()
    }
    driven = driven_by(msgspec.structs.replace(plan, trials=trials), vehicle)
    found = output_error([slower(fading(r, *thrust), rate) for r in driven], vehicle)
    return found.findings_of(FindingKind.PARAMETER_DRIFT, FindingKind.CLOCK_DRIFT)


@pytest.mark.system
@pytest.mark.parametrize(
    ("names", "force", "thrust", "off"),
    [
        at_length(("S1", "S2", "S3"), None, (1.1, 1.0), 2.0),
        (("S1", "S2", "S3"), PUSH, (1.25, 1.0), 5.0),
        at_length(("S7",), PUSH, (1.0, 1.25), 5.0),
    ],
)
def test_thrust_that_falls_or_rises_is_told(mp, names, force, thrust, off):
    found = drift_of(mp, with_seed(load_plan("hard"), 700), force, names, thrust=thrust)
    assert [finding.part("axis") for finding in found] == ["surge", "sway", "yaw"]
    falls = thrust[1] < thrust[0]
    for finding in found:
        assert finding.kind is FindingKind.PARAMETER_DRIFT
        assert finding.values["quantity"] == "thrust"
        assert finding.values["lower"] == ("end" if falls else "beginning")
        assert finding.values["higher"] == ("beginning" if falls else "end")
        assert finding.part("recording").removesuffix("-MP") in names
        # one slope for all of them: none is at fault
        assert finding.values["of"] == ("all recordings" if len(names) > 1 else "one recording")
        expected = 1.0 - min(thrust) / max(thrust)
        assert finding.number("change") == pytest.approx(expected, abs=off / 100.0)


@pytest.mark.parametrize(("names", "rate"), [(("S7",), 1e-3), at_length(("S1", "S2", "S3"), -1e-3)])
def test_a_clock_that_drifts_is_told_with_its_rate_and_is_no_payload(mp, names, rate):
    (finding,) = drift_of(mp, with_seed(load_plan("hard"), 707), PUSH, names, rate=rate)
    assert finding.kind is FindingKind.CLOCK_DRIFT
    assert finding.number("factor") == pytest.approx(1.0 + rate, abs=0.1 * abs(rate))
    assert finding.values["later"] == ("end" if rate > 0.0 else "beginning")
    assert finding.part("recording").removesuffix("-MP") in names


@pytest.mark.parametrize(
    ("preset", "force"),
    [("paper-like", None), on_request("hard", None), on_request("paper-like", PUSH), at_length("hard", PUSH)],
)  # fmt: skip
@pytest.mark.parametrize("names", [("S1", "S2", "S3"), at_length(("S7",)), at_length(("S6",))])
def test_a_boat_that_stays_what_it_is_has_no_note(mp, preset, force, names):
    assert drift_of(mp, with_seed(load_plan(preset), 711), force, names) == ()


@pytest.mark.system
def test_what_a_structure_lacks_is_no_change_of_the_boat(mp):
    """Quadratic drag, that the plant has: what is left follows speed, which comes and goes."""
    driven = driven_by(planned("hard", "S1", "S2", "S3", seed=741), mp)
    kept = [t for t in mp.structure.terms if t.coefficient not in {"X_uu", "Y_vv", "N_rr"}]
    found = output_error(driven, mp.with_terms(kept))
    assert found.findings_of(FindingKind.PARAMETER_DRIFT) == ()
