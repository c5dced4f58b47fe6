# SPDX-License-Identifier: MIT
"""Title, verdict in three sentences, warnings."""

from html import escape

from seatrial.report.evidence import Evidence
from seatrial.report.names import names_in, sentence
from seatrial.report.sections.base import Section
from seatrial.report.verdict import verdict
from seatrial.sanity import concerns


def section(evidence: Evidence) -> Section:
    """The first thing that is read."""
    model = evidence.model
    names = names_in(model)
    said = "".join(f"<p>{sentence(line, names)}</p>" for line in verdict(evidence))
    warned = "".join(f'<p class="warning">{sentence(t, names)}</p>' for t in concerns(model))
    html = f"""<header><h1>{escape(model.name)}</h1>
<p class="subtitle">Dynamic model, identified and put to the test</p></header>
<section id="verdict"><h2 class="quiet">Verdict</h2>
<div class="said">{said}</div>
{warned}</section>"""
    return Section("verdict", "", html)
