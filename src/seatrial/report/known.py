# SPDX-License-Identifier: MIT
"""The report's section on what is known of each parameter, and what only of some together."""

from html import escape

from seatrial.identifiability import Finding, Identifiability, Verdict, identifiability
from seatrial.identify.text import combined, condition_said
from seatrial.model import Model
from seatrial.report.markup import NOT_A_NUMBER, data, listing, number, symbol, table, unit

SHADES = ("0,114,178", "213,94,0")  # of negative and positive correlations


def section(model: Model) -> str:
    """Verdicts, combinations, correlation map; nothing where nothing was estimated."""
    found = identifiability(model)
    if not found.names:
        return ""
    said = [escape(line) for line in [*map(combined, found.combinations), *condition_said(found)]]
    notes = [escape(note) for note in model.estimator.notes]
    return f"""<section id="known"><h2>What is known</h2>
<p class="note">Sharp: known to 5 %. Usable: to 20 %. Errors of latency, lag and dead zone count
against 0.1 s and 0.1, or against the value if that is larger. Two parameters that hang together are
poorly known each, and their combination well.</p>
{verdicts(found)}
{listing([*said, *notes])}
<h3>Correlations</h3>
<p class="note">In per cent; blue: as one is larger, the other is smaller.</p>
{correlation_map(found)}</section>"""


def verdicts(found: Identifiability) -> str:
    """A row for each parameter that was estimated."""
    head = [
        "parameter",
        "value",
        "standard error",
        "unit",
        "relative error",
        "verdict",
        "most with",
    ]
    rows = [_row(f) for f in found.findings if f.verdict is not Verdict.GIVEN]
    kept = [f for f in found.findings if f.verdict is not Verdict.GIVEN]
    loose = [i for i, f in enumerate(kept) if not f.verdict.enough]
    return table(head, rows, kind="numbers known", marked=loose)


def correlation_map(found: Identifiability) -> str:
    """The correlations as a table whose cells are the darker the closer they are to 1 or -1."""
    names = [symbol(name) for name in found.names]
    rows = []
    for i, name in enumerate(names):
        cells = "".join(
            f'<td style="background:rgba({SHADES[rho > 0]},{abs(rho):.2f})">'
            f'<data value="{rho:.4f}">{100 * rho:.0f}</data></td>'
            if i != j else "<td></td>"
            for j, rho in enumerate(found.correlation[i].tolist())
        )  # fmt: skip
        rows.append(f'<tr><th scope="row">{name}</th>{cells}</tr>')
    top = "".join(f'<th scope="col">{name}</th>' for name in names)
    return (
        f'<div class="scroll" tabindex="0"><table class="numbers correlations"><thead><tr><td></td>{top}'
        f"</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _row(found: Finding) -> list[str]:
    partner = NOT_A_NUMBER
    if found.partners:
        name, rho = found.partners[0]
        partner = f"{symbol(name)} ({number(rho, 2)})"
    said = found.verdict.value
    if found.verdict is Verdict.ZERO and found.reach is not None:
        said += f", at most {100 * found.reach:.2g} % of full thrust"
    return [
        symbol(found.name),
        data(found.value),
        data(found.error, 2),
        unit(found.unit),
        f"{100 * found.relative:.2g} %",
        escape(said),
        partner,
    ]
