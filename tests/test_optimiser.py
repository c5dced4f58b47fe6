# SPDX-License-Identifier: MIT
"""The search's steps within bounds."""

import pytest
from conftest import CSE1

import seatrial
from seatrial.boat.actuators import ESTIMATE
from seatrial.boat.schema import ChainGroup
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.selection.actuator_stages import actuator_groups


@pytest.mark.system
def test_latencies_of_the_real_ship_are_found_beside_a_lag_at_its_bound():
    """The lag ends at its bound, and drags none of the latencies along: they are those without a lag."""
    vehicle = seatrial.load_vehicle(CSE1 / "vehicle.yaml")
    kinds = actuator_groups(vehicle)
    asked = [ChainGroup(name=n, actuators=of, latency=ESTIMATE) for n, of in kinds.items()]
    recording = seatrial.read(CSE1 / "csv" / "CSE1_data_random_run1.csv", vehicle)
    recordings = [recording.cut(200.0, 380.0)]
    free, without = (
        output_error(
            recordings,
            vehicle.with_chain([*vehicle.file.chain, *asked, *lag]),
            settings=OutputErrorSettings(select_stages=False),
        )
        for lag in ([], [ChainGroup(lag=0.0)])
    )
    found, none = (
        dict(zip(m.vehicle.constants.names, m.constants.tolist(), strict=True))
        for m in (free, without)
    )
    assert found["lag"] < 0.005
    for force in kinds:
        name = f"latency.{force}"
        assert found[name] == pytest.approx(none[name], abs=0.005), name
