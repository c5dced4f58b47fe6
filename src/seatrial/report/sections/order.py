# SPDX-License-Identifier: MIT
"""The report's sections in the order of the page."""

from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections import (
    actuators,
    advice,
    coefficients,
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
from seatrial.report.sections.base import Section

SECTION_ORDER = (
    verdict, known, coefficients, actuators, recorded, horizons, prediction, errors, scores,
    homogeneity, physics, advice, provenance,
)  # fmt: skip


def all_sections(evidence: Evidence) -> list[Section]:
    """Every section with content."""
    return [found for one in SECTION_ORDER if (found := one.section(evidence)) is not None]
