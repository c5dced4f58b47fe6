# SPDX-License-Identifier: MIT
"""Tables II and III, and Figs. 5 to 7, for simulated trials."""

from typing import Any

import numpy as np

from benchmarks.studies.paper.trials import HORIZON, boat, identified, measured_errors, paired, rms
from seatrial.evaluation.prediction import predict
from seatrial.util.statistics import autocorrelation, kurtosis
from tests.boats.scenes import ALLOCATIONS, UNSEEN, driven

PLANS = ("paper-like", "hard")
LAGS = 60
METHODS = ("equation-error", "output-error")
PRINTED = {  # Table II: MP, AF
    "X_u": (-0.10, -0.20), "X_uu": (-1.67, -1.74), "X_F": (0.15, 0.14),
    "Y_v": (-0.23, -0.23), "Y_vv": (-1.26, -0.80), "Y_F": (0.26, 0.20),
    "N_r": (-0.73, -0.48), "N_rr": (-0.30, -0.20), "N_F": (1.39, 1.3),
    "N_ud": (-0.14, 0.04), "N_uu": (1.07, 0.63),
}  # fmt: skip
PRINTED_ERRORS = {"MP": (0.023, 0.035, 0.10), "AF": (0.018, 0.022, 0.07)}  # Table III


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run."""
    return [(plan, a, seed) for seed in seeds for plan in PLANS for a in ALLOCATIONS]


def work(plan: str, allocation: str, seed: int) -> dict[str, Any]:
    """One boat, seven trials, both methods."""
    vehicle = boat(allocation)
    trials = driven(plan, vehicle, seed)
    out: dict[str, Any] = {}
    for method in METHODS:
        model = identified(trials, vehicle, method)
        last = predict(model, trials[UNSEEN].recording, HORIZON)
        errors = last.errors
        rho = autocorrelation(errors, last.index, LAGS)
        out[method] = {
            "coefficients": dict(zip(model.values, model.coefficients.tolist(), strict=True)),
            "paired": paired(model, trials),
            "unseen": rms(errors),
            "floor": last.floor.tolist(),
            "kurtosis": [kurtosis(e) for e in errors.T],
            "rho": rho.T.round(4).tolist(),
            "steps": last.steps,
        }
    return out


def beyond(rho: list[float], steps: int) -> float:
    """Root mean square of the autocorrelation from lag k on, where a perfect model has none."""
    return float(np.sqrt(np.mean(np.square(rho[steps:]))))


__all__ = ["PRINTED", "PRINTED_ERRORS", "beyond", "keys", "measured_errors", "work"]
