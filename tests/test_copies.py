# SPDX-License-Identifier: MIT
"""Models, vehicles and predictors copied, pickled, shared by threads, and given absurd stamps."""

import copy
import pickle
import threading
import time

import export_names
import numpy as np
import pytest

import seatrial
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Health, Predictor, Taken
from seatrial.util.errors import PredictorError

ABSURD = [4.1e9, 1e15, 1e16, 1e17, 1.7e18, 1e300, -1e16, -1e300, float("inf"), float("nan")]
COPIES = [copy.copy, copy.deepcopy, lambda own: pickle.loads(pickle.dumps(own))]
NANO = 1_000_000_000


@pytest.fixture
def boat() -> seatrial.Model:
    return export_names.plain_boat()


@pytest.mark.parametrize("how", COPIES)
def test_a_model_and_its_vehicle_are_the_same_as_a_copy(tmp_path, boat, how):
    _ = boat.boat, boat.parameters, boat.known_vehicle.chain  # what the core keeps
    other = how(boat)
    assert other is not boat
    for name, model in (("own", boat), ("other", other)):
        seatrial.save(model, tmp_path / f"{name}.yaml")
    assert (tmp_path / "other.yaml").read_text() == (tmp_path / "own.yaml").read_text()
    assert not other.coefficients.flags.writeable
    vehicle = how(boat.vehicle)
    assert vehicle == boat.vehicle
    np.testing.assert_array_equal(vehicle.mix, boat.vehicle.mix)
    assert how(boat.structure) == boat.structure


def moved(kind, boat):
    made = kind(boat)
    scale = 1.0 if kind is Predictor else NANO
    for i in range(20):
        t = 1000 + 0.1 * i
        taken = made.pose(t if kind is Predictor else round(scale * t), [0.05 * i, 0, 0])
        assert taken is Taken.USED
    return made, round(scale)


@pytest.mark.parametrize("how", COPIES[:2])
@pytest.mark.parametrize("kind", [Predictor, Odometer])
def test_a_copy_goes_on_by_itself(boat, kind, how):
    own, second = moved(kind, boat)
    other = how(own)
    look = "at" if kind is Predictor else "look"
    before = getattr(own, look)(1002 * second)
    np.testing.assert_array_equal(getattr(other, look)(1002 * second).pose, before.pose)
    other.command(1002 * second, [1.0, 1.0, 1.0])
    np.testing.assert_array_equal(getattr(own, look)(1002 * second).pose, before.pose)
    ahead = [getattr(made, look)(1003 * second).velocity[0] for made in (own, other)]
    assert ahead[1] - ahead[0] > 0.1


@pytest.mark.parametrize("kind", [Predictor, Odometer])
def test_a_running_filter_has_no_pickle_and_says_so(boat, kind):
    with pytest.raises(
        PredictorError, match=f"a running {kind.__name__} can't be pickled; pickle its model"
    ):
        pickle.dumps(kind(boat))


@pytest.mark.parametrize("stamp", ABSURD)
def test_an_absurd_stamp_is_refused_at_once(boat, stamp):
    own, _ = moved(Predictor, boat)
    begin = time.process_time()
    for _ in range(3):
        assert own.pose(stamp, [0, 0, 0]) is Taken.NOT_A_NUMBER
        assert own.command(stamp, [0.1, 0, 0]) is Taken.NOT_A_NUMBER
        assert own.scale(stamp, [3.0]) is Taken.NOT_A_NUMBER
    assert Health.BEYOND_REACH in own.at(stamp).health
    assert Predictor(boat).pose(stamp, [0, 0, 0]) is Taken.NOT_A_NUMBER
    assert Predictor(boat).at(stamp).health
    assert time.process_time() - begin < 5.0
    assert own.pose(1002.0, [1.0, 0, 0]) is Taken.USED


@pytest.mark.parametrize("stamp", [4e9 - 1, -4e9 + 1])
def test_the_latest_stamps_that_are_used_are_still_told_apart(boat, stamp):
    own = Predictor(boat)
    for i in range(5):
        assert own.pose(stamp + 0.1 * i, [0.05 * i, 0, 0]) is Taken.USED
    assert own.at(stamp + 0.4).velocity[0] == pytest.approx(0.5, abs=0.2)


def test_threads_share_a_predictor(boat):
    """Their calls take turns: as many inputs as without threads, and a finite state."""
    own = Predictor(boat)
    own.pose(1000.0, [0, 0, 0])
    failed: list[object] = []

    def work(offset: float) -> None:
        for i in range(200):
            taken = own.pose(1000.0 + 0.01 * i + offset, [0.001 * i, 0, 0])
            if (
                taken not in (Taken.USED, Taken.STALE, Taken.TWICE, Taken.NO_ROOM)
                or not np.isfinite(own.at(1000.0 + 0.01 * i).pose).all()
            ):
                failed.append(taken)

    threads = [threading.Thread(target=work, args=(k * 1e-3,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
