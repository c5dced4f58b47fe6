# SPDX-License-Identifier: MIT
"""Which terms a boat's recordings support, and on which of them its repeats agree."""

from seatrial.identification.selection.terms.candidates import default_candidates, given_candidates
from seatrial.identification.selection.terms.console import (
    SELECTION_FORMAT,
    chosen_terms_text,
    selection_json,
    selection_text,
)
from seatrial.identification.selection.terms.decisions import Selection
from seatrial.identification.selection.terms.missing_term import missing_term_findings
from seatrial.identification.selection.terms.select_terms import choose_structure, select

__all__ = [
    "SELECTION_FORMAT",
    "Selection",
    "choose_structure",
    "chosen_terms_text",
    "default_candidates",
    "given_candidates",
    "missing_term_findings",
    "select",
    "selection_json",
    "selection_text",
]
