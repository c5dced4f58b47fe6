# SPDX-License-Identifier: MIT
"""What identify prints: digits, verdicts, noise and minutes in words."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import seatrial
from seatrial.boat.findings import FindingKind, finding_of, finding_text
from seatrial.boat.schema import (
    ChainGroup,
    CorrelatedEntry,
    EnvelopeEntry,
    EstimatorEntry,
    NoiseEntry,
    ProcessEntry,
)
from seatrial.boat.schema import RecordingEntry as Entry
from seatrial.identification.console import minutes
from seatrial.identification.estimator import OUTPUT_ERROR
from seatrial.identification.methods import summary
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.format import percent, plus_minus, table

HIDDEN = finding_of(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE, "t1", "t2")


@pytest.fixture(scope="module")
def model():
    """Ten minutes: X_u to 15 %, lag and latency apart by 50 ms but their sum to 1 ms, the rest to 1 %."""
    vehicle = seatrial.load_vehicle("mallard-af")
    whole = vehicle.with_chain([ChainGroup(latency=0.02, lag=0.08)])
    plant = plant_model(load_plan("clean"), vehicle)
    errors = [*(0.01 * np.abs(plant.coefficients)), 0.0, 0.0]
    covariance = np.diag(np.square(errors))
    covariance[0, 0] = 0.03**2
    apart, same = 0.05**2, 0.001**2
    covariance[-2:, -2:] = apart * np.array([[1, -1], [-1, 1]]) + same / 4
    return replace(
        plant, vehicle=whole, constants=whole.constants.values, covariance=covariance,
        envelope=EnvelopeEntry({"u": (-0.2, 0.2)}, dict.fromkeys(("F_u", "F_v", "F_r"), (-1.0, 1.0))),
        noise=NoiseEntry(0.004, 0.003, ProcessEntry(1e-6, 1e-6, 0.0068, 0.013, 2.0)),
        recordings=(Entry("S1", 200.0), Entry("S2", 400.0)), estimator=EstimatorEntry(OUTPUT_ERROR, findings=[HIDDEN]),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (-0.23456, 0.0651, "-0.235 ± 0.065"), (-1.7391, 0.00164, "-1.7391 ± 0.0016"),
        (1234.5, 120.0, "1234 ± 120"), (1e-9, 2e-9, "1.000e-09 ± 2.0e-09"), (2.0, 0.0, "2"),
        (-0.0003, 0.017, "0.000 ± 0.017"),
    ],
)  # fmt: skip
def test_both_digits_of_the_error_and_no_more(value, error, shown):
    assert plus_minus(value, error) == shown


def test_the_summary_is_a_screenful_with_a_verdict_on_every_line(model):
    text = summary(model)
    lines = {line.split()[0]: line for line in text.splitlines() if line.startswith("  ")}
    assert set(lines) == set(model.parameters)
    assert lines["X_u"].split("1/s")[1].strip() == "usable (15 %)"
    assert lines["N_F"].endswith("sharp (1 %)")
    assert (
        "latency and lag can't be told apart (-1.00): their sum is 0.1000 ± 0.0010 s, sharp" in text
    )
    assert finding_text(HIDDEN) in text
    assert len(text.splitlines()) < 24


def test_noise_in_words(model):
    """0.0068 of 0.14 and 0.20 m/s^2 are 4.9 and 3.4 %, 0.013 of 1.3 rad/s^2 is 1 %."""
    assert (
        "Pose noise 4 mm and 3 mrad; process noise (disturbance force): 4.9 % in surge, 3.4 % in sway and "
        "1 % in yaw of the largest commanded force, time constant 2 s." in summary(model)
    )
    process = msgspec.structs.replace(model.noise.process, earth_fixed=True)
    windy = replace(model, noise=msgspec.structs.replace(model.noise, process=process))
    assert "time constant 2 s, earth-fixed." in summary(windy)
    drift = Entry("S1", 60.0, effects={"current_x": 0.1, "current_y": 0.0})
    assert (
        "earth-fixed, including the current of the recordings, which is not known on board."
        in summary(replace(windy, recordings=(drift,)))
    )
    quiet = replace(
        model, noise=NoiseEntry(0.004, 0.003, ProcessEntry(2e-3, 9e-3, 1e-6, 1e-6, 2.0))
    )
    quietly = "no significant process noise; velocity random walk 2 mm/s and 9 mrad/s in 1 s."
    assert quietly in summary(quiet)
    coloured = replace(model, noise=NoiseEntry(1e-3, 2e-3, None, CorrelatedEntry(4e-3, 5e-3, 0.3)))
    assert (
        "Pose noise 1 mm and 2 mrad (white), 4 mm and 5 mrad (time-correlated over 0.3 s)."
        in summary(coloured)
    )
    white = replace(model, noise=NoiseEntry(1e-3, 2e-3, None, CorrelatedEntry(1e-9, 5e-3, 0.3)))
    assert "2 mrad (white), 5 mrad (time-correlated over 0.3 s)." in summary(white)


def test_minutes_until_it_is_known_to_five_per_cent(model):
    """15 % after 10 min: 5 % after nine times that. Lag and latency need none: their sum is known."""
    assert (
        "Driven like these 10.0 min, knowing them to 5 % takes 90 min for X_u; the report says"
        in summary(model)
    )
    sharp = replace(model, covariance=model.covariance / 100)
    assert "Halving every error takes four times these 10.0 min." in summary(sharp)
    assert [minutes(m) for m in (3.26, 44.0, 150.0, 5000.0)] == [
        "3.3 min",
        "44 min",
        "2.5 h",
        "83 h",
    ]


def test_tables_align():
    shown = table(["", "a", "bb"], [["x", "1", "2"], ["yy", "10", "3"]]).splitlines()
    assert shown == ["       a  bb", "  x    1   2", "  yy  10   3"]
    shown = table(
        ["a", "n", "words"], [["x", "10", "b"], ["yy", "3", ""]], text=(0, 2)
    ).splitlines()
    assert shown == ["  a    n  words", "  x   10  b", "  yy   3"]


@pytest.mark.parametrize(
    ("share", "said"),
    [(0.0005, "0.05 %"), (0.123, "12 %"), (0.9949, "99 %"), (1.06, "106 %"), (23.4, "2340 %")],
)
def test_shares_are_read_without_powers_of_ten(share, said):
    assert percent(share) == said
