# SPDX-License-Identifier: MIT
"""Title, verdict in three sentences, warnings."""

from html import escape

from seatrial.boat.physics import model_concerns
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.verdict import verdict
from seatrial.report.sections.base import Section
from seatrial.report.text.names import names_in, sentence


def section(evidence: Evidence) -> Section:
    """The head of the page."""
    model = evidence.model
    names = names_in(model)
    lines = "".join(f"<p>{sentence(line, names)}</p>" for line in verdict(evidence))
    warnings = "".join(
        f'<p class="warning">{sentence(t, names)}</p>' for t in model_concerns(model)
    )
    html = f"""<header><h1>{escape(model.name)}</h1>
<p class="subtitle">Dynamic model, identified and validated</p></header>
<section id="verdict"><h2 class="quiet">Verdict</h2>
<div class="said">{lines}</div>
{warnings}</section>"""
    return Section("verdict", "", html)
