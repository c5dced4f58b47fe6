# SPDX-License-Identifier: MIT
"""The report's sections, one function each, as HTML."""

from collections.abc import Sequence
from html import escape
from importlib.metadata import version
from string import Template

from seatrial.frames import AXES, SYMBOLS, Axes
from seatrial.identify.equation_error import METHOD
from seatrial.model import Model
from seatrial.report import prose, tables, words
from seatrial.report.figures import SCATTER
from seatrial.report.markup import equation, listing, number
from seatrial.report.runs import WINDOW, Run
from seatrial.report.words import UNITS, minutes
from seatrial.sanity import TOLD_APART, concerns, sanity_line

BUTTONS = (
    ("whole", "whole run"),
    ("window", f"{WINDOW:g} s"),
    ("earlier", "‹ earlier"),
    ("later", "later ›"),
)


def verdict(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """Title, verdict, warnings, what to do next; `horizon` in s."""
    said = "".join(f"<p>{escape(line)}</p>" for line in words.verdict(model, runs, horizon))
    warned = "".join(f'<p class="warning">{escape(text)}</p>' for text in concerns(model))
    todo = [escape(text) for text in words.advice(model, runs)]
    return f"""<header><h1>{escape(model.name)}</h1>
<p class="subtitle">Dynamic model, identified and put to the test</p></header>
<section id="verdict"><h2 class="quiet">Verdict</h2>
<div class="said">{said}</div>
<p class="sanity">{escape(sanity_line(model))}</p>
{warned}
<h3>What to do next</h3>
{listing(todo, "advice") if todo else prose.ALL_WELL}</section>"""


def model(model: Model) -> str:
    """Equations, coefficients, least-squares steps."""
    structure = model.structure
    named = listing([equation(structure, axis) for axis in range(3)], "equations")
    valued = listing([equation(structure, axis, model.values) for axis in range(3)], "equations")
    other = prose.OTHER_AXES if model.vehicle.axes is Axes.FRD else ""
    remark = prose.LEAST_SQUARES if model.estimator.method == METHOD else ""
    found = f"<h3>How they were found</h3>{tables.steps(model)}" if model.estimator.steps else ""
    return f"""<section id="model"><h2>Model</h2>
{named}
<p>With numbers (SI units, forces in command units):</p>
{valued}
<h3>Coefficients</h3>
<p class="note">{prose.AXES}{other} {prose.TOLD_APART.format(TOLD_APART)}</p>
{tables.coefficients(model)}
{found}{remark}</section>"""


def recorded(runs: Sequence[Run]) -> str:
    """Track, faults, excitation and coverage of every recording."""
    parts = "\n".join(_recorded(run, i, i == _first(runs)) for i, run in enumerate(runs))
    said = Template(prose.RECORDED).substitute(scatter=SCATTER)
    return f"""<section id="recorded"><h2>What was recorded</h2>
<p class="note">{said}</p>
{parts}</section>"""


def prediction(runs: Sequence[Run], horizon: float) -> str:
    """Measured against predicted velocities, histograms, autocorrelations; `horizon` in s."""
    parts = "\n".join(_prediction(run, i, i == _first(runs)) for i, run in enumerate(runs))
    said = Template(prose.PREDICTION).substitute(horizon=f"{horizon:g}", window=f"{WINDOW:g}")
    return f"""<section id="prediction"><h2>Prediction {horizon:g} s ahead</h2>
<p class="note">{said}</p>
{parts}</section>"""


def scores(runs: Sequence[Run], horizon: float) -> str:
    """Table III for all axes, and what its columns mean; `horizon` in s."""
    marked = prose.MARKED if any(run.score.excited for run in runs) else ""
    said = Template(prose.SCORES).substitute(horizon=f"{horizon:g}")
    return f"""<section id="scores"><h2>Scores {horizon:g} s ahead</h2>
{tables.scores(runs)}
{marked}<dl class="note">{said}</dl></section>"""


def provenance(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """Where everything comes from; `horizon` in s."""
    noise, step = model.noise, model.integration
    chosen = ", ".join(f"{k} = {v}" for k, v in model.estimator.settings.items()) or "none"
    position, heading = number(1e3 * noise.position, 2), number(1e3 * noise.heading, 2)
    facts = [
        ("seatrial", version("seatrial")),
        ("method", f"{model.estimator.method} (settings: {chosen})"),
        ("structure", model.structure.name),
        ("allocation", model.vehicle.scheme.value),
        ("axes", f"files {model.vehicle.axes.value}; in this report forward-left-up"),
        ("integration", f"{step.scheme}, step {number(step.step)} s"),
        ("pose noise", f"{position} mm, {heading} mrad"),
        ("horizon", f"{horizon:g} s"),
    ]
    lines = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in facts)
    chain = tables.constants(model) if model.vehicle.constants.names else prose.NO_CONSTANTS
    return f"""<section id="provenance"><h2>Provenance</h2>
<dl class="facts">{lines}</dl>
<h3>Files</h3>{tables.files(model, runs)}
<h3>Actuator chain</h3>{chain}
<h3>Envelope</h3><p class="note">{prose.ENVELOPE}</p>{tables.envelope(model)}
</section>"""


def _first(runs: Sequence[Run]) -> int:
    """The recording that is open from the start: the first that the model has not seen."""
    return next((i for i, run in enumerate(runs) if run.unseen), 0)


def _recorded(run: Run, place: int, opened: bool) -> str:
    recording = run.recording
    facts = (
        f"{minutes(recording.duration)}, {len(recording.t)} poses at "
        f"{number(1.0 / recording.period, 3)} Hz, {100 * run.masked:.1f} % left out"
    )
    broken = "<p>No faults found.</p>"
    if recording.faults:
        title = f"<summary>every fault ({len(recording.faults)})</summary>"
        every = f'<details class="fine">{title}{tables.faults(run)}</details>'
        broken = tables.fault_kinds(run) + every
    cover = "".join(
        _plot(place, f"coverage-{s}", f"{a} speed against command", "small")
        for a, s in zip(AXES, SYMBOLS, strict=True)
    )
    inside = f"""<div class="pair">{_plot(place, "track", "track of the boat", "square")}
<div>{tables.excitations(run)}{broken}</div></div>
<div class="three">{cover}</div>"""
    return _foldable(recording.name, facts, inside, opened)


def _prediction(run: Run, place: int, opened: bool) -> str:
    sizes = [
        f"{sign} {number(run.score.scores[sign].rms * scale, 2)} {name}"
        for sign, (name, scale) in zip(SYMBOLS, UNITS, strict=True)
    ]
    facts = f"{'not seen' if run.unseen else 'seen'}; RMS error {', '.join(sizes)}"
    whole = f"{run.t[0]:.6g},{run.t[-1]:.6g}"
    window = f"{run.window[0]:.6g},{run.window[1]:.6g}"
    buttons = "".join(
        f'<button type="button" data-do="{do}">{label}</button>' for do, label in BUTTONS
    )
    inside = (
        f'<div class="linked" data-whole="{whole}" data-window="{window}">'
        f'<div class="bar">{buttons}</div>'
        + "".join(_axis(run, place, axis) for axis in range(3))
        + "</div>"
    )
    return _foldable(run.recording.name, facts, inside, opened)


def _axis(run: Run, place: int, axis: int) -> str:
    sign, (name, scale) = SYMBOLS[axis], UNITS[axis]
    found, label = run.score.scores[sign], f"{AXES[axis]} velocity"
    told = f"RMS {number(found.rms * scale, 2)} {name}, kurtosis {number(found.kurtosis, 2)}"
    drawn = _plot(place, f"velocity-{sign}", f"{label}, measured and predicted", "wide")
    spread = _plot(place, f"histogram-{sign}", f"histogram of its errors: {told}", "small", told)
    hung = _plot(place, f"autocorrelation-{sign}", "autocorrelation of its errors", "small")
    return f"""<h4>{AXES[axis].capitalize()} <i>{sign}</i></h4>
<div class="axis">{drawn}<div>{spread}{hung}</div></div>"""


def _plot(place: int, figure: str, label: str, size: str, caption: str = "") -> str:
    above = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return (
        f'<figure>{above}<div class="plot {size}" data-run="run-{place}" data-figure="{figure}" '
        f'role="img" aria-label="{escape(label)}"></div></figure>'
    )


def _foldable(name: str, facts: str, inside: str, opened: bool) -> str:
    title = f"<summary><b>{escape(name)}</b> <span>{escape(facts)}</span></summary>"
    return f'<details class="run"{" open" if opened else ""}>{title}\n{inside}</details>'
