# SPDX-License-Identifier: MIT
"""The report's sections in the order of the page."""

from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections import (
    actuators,
    advice,
    coefficients,
    effects,
    errors,
    homogeneity,
    horizons,
    known,
    physics,
    prediction,
    provenance,
    recorded,
    scores,
    verdict,
)
from seatrial.report.sections.base import Section, with_folds

SECTION_ORDER = (
    verdict, known, coefficients, effects, actuators, recorded, horizons, prediction, errors, scores,
    homogeneity, physics, advice, provenance,
)  # fmt: skip


FOLDED = frozenset(
    ("actuators", "recorded", "errors", "scores", "repeat", "physics", "advice", "provenance")
)


def all_sections(evidence: Evidence) -> list[Section]:
    """Every section with content; those that few readers look at are folded."""
    found = [section for one in SECTION_ORDER if (section := one.section(evidence)) is not None]
    return with_folds(found, FOLDED)
