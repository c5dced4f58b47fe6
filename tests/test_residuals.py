# SPDX-License-Identifier: MIT
"""What is left out of a model shows in its residuals; a right model's show nothing."""

from dataclasses import replace

import numpy as np
import pytest
from test_bootstrap import lasting
from test_filtering import one_trial, truth  # noqa: F401

from seatrial.evaluation.filtering import run_filter
from seatrial.evaluation.residuals import Correlation, _correlation, in_words, residuals
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.util.statistics import autocorrelation, bartlett_band, cross_correlation, white_band


@pytest.fixture(scope="module")
def quiet(mp):
    """0.7 mm and 3 mrad of noise."""
    return one_trial("paper-like", mp, 200.0)


def found(model, recording):
    left = residuals(model, recording, run_filter(model, recording))
    return sorted((c for c in left if c.found), key=lambda c: -abs(c.peak) / c.limit)


def changed(model, **values):
    theta = model.coefficients.copy()
    for name, value in values.items():
        theta[model.structure.coefficients.index(name)] = value
    return replace(model, coefficients=theta)


def test_a_right_model_leaves_nothing(truth, quiet):  # noqa: F811
    assert found(truth, quiet.recording) == []


def test_a_missing_term_shows_in_its_axis_after_its_force(truth, quiet):  # noqa: F811
    worst = found(changed(truth, N_uu=0.0, N_ud=0.0), quiet.recording)[0]
    assert (worst.residual, worst.force) == ("r", "F_u")
    assert worst.lag >= 0
    assert in_words(worst).startswith("residuals in yaw follow F_u")
    assert "a term is missing, or a delay is wrong" in in_words(worst)


def test_an_axis_that_follows_its_own_force_may_be_of_a_boat_that_changed(truth, quiet):  # noqa: F811
    heavier = found(changed(truth, X_F=1.3 * truth.values["X_F"]), quiet.recording)[0]
    assert (heavier.residual, heavier.force) == ("u", "F_u")
    assert "mass, thrust or drag has changed" in in_words(heavier)


@pytest.mark.parametrize(
    ("peak", "limit", "said"),
    [(0.2, 0.09, "+0.20 (95 % limit 0.09)"), (-0.0612, 0.0583, "-0.061 (95 % limit 0.058)")],
)
def test_a_correlation_and_its_limit_have_the_digits_that_tell_them_apart(peak, limit, said):
    assert said in in_words(Correlation("r", "F_u", 0.1, [], 0.05, limit, True, peak, 0.3))


def shifted(quiet, seconds):
    commands = quiet.recording.commands
    stamps = commands.stamps + round(seconds * 1e9)
    return make_recording(
        "shifted", quiet.pose_stamps, quiet.pose, Signal(commands.names, stamps, commands.values)
    )


def test_a_delay_shows_after_the_force_and_a_late_clock_before_it(truth, quiet):  # noqa: F811
    early = found(truth, shifted(quiet, -0.2))
    assert len(early) == 3
    assert all(c.lag >= 0 and c.residual == c.force[-1] for c in early)
    assert "a delay is wrong" in in_words(early[0])
    late = found(truth, shifted(quiet, 0.3))
    assert any(c.lag < 0 and "late clock of the commands" in in_words(c) for c in late)


def test_of_a_few_seconds_nothing_is_told(truth, quiet):  # noqa: F811
    """Correlations over so many lags of so few residuals were beyond 1."""
    for length, told in ((40.0, True), (12.0, False)):
        part = quiet.recording.cut(0.0, length)
        assert bool(residuals(truth, part, run_filter(truth, part))) is told


def test_what_is_found_is_what_is_told():
    """A value that leaks to before the force is no peak, and nothing that a note may speak of."""
    values = np.zeros(9)
    values[1], values[6] = 0.5, 0.02
    one = _correlation(("r", "F_r"), 0.1, values, np.zeros(9), np.array([0.1, 0.2]))
    assert (one.peak, one.found) == (0.02, False)
    values[6] = 0.3
    one = _correlation(("r", "F_r"), 0.1, values, np.zeros(9), np.array([0.1, 0.2]))
    assert (one.peak, one.found) == (0.3, True)


def test_correlation_is_that_of_the_pairs_that_are_there():
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(200, 2)), rng.normal(size=(200, 3))
    x[3:, 0] += y[:-3, 1]  # follows it 3 samples later
    x[50:60] = np.nan
    got = cross_correlation(x, y, 5)
    assert got.shape == (11, 2, 3)
    assert np.unravel_index(np.abs(got).argmax(), got.shape) == (5 + 3, 0, 1)
    good = np.isfinite(x[:, 0])
    a = np.where(good, x[:, 0] - x[good, 0].mean(), 0.0)
    b = y[:, 1] - y[:, 1].mean()
    for lag in (-5, -1, 0, 3):
        pairs = [(i, i - lag) for i in range(200) if 0 <= i - lag < 200 and good[i]]
        mean = sum(a[i] * b[j] for i, j in pairs) / len(pairs)
        scale = np.sqrt(np.sum(a**2) / good.sum() * np.mean(b**2))
        assert got[lag + 5, 0, 1] == pytest.approx(mean / scale, rel=1e-9)


def test_bartletts_band_holds_where_both_signals_last():
    rng = np.random.default_rng(1)
    n, inside, fooled = 3000, [], []
    for _ in range(150):
        x, y = lasting(rng, n, 5)[:, None], lasting(rng, n, 50)[:, None]
        rho = [autocorrelation(s, np.arange(n), n // 4) for s in (x, y)]
        got = np.abs(cross_correlation(x, y, 30))[:, 0, 0]
        inside.append(got < bartlett_band(*rho, n)[0, 0])
        fooled.append(got < white_band(n))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.03)
    assert np.mean(fooled) < 0.7
