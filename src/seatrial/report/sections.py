# SPDX-License-Identifier: MIT
"""The report's sections, one function each, as HTML."""

from collections.abc import Sequence
from html import escape
from importlib.metadata import version

from seatrial.frames import AXES, SYMBOLS, Axes
from seatrial.model import Model
from seatrial.report import tables, words
from seatrial.report.figures import BIN_RANGE, LAGS
from seatrial.report.markup import equation, listing, number
from seatrial.report.runs import WINDOW, Run
from seatrial.report.words import UNITS, minutes


def verdict(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """Title, verdict, warnings, what to do next."""
    said = "".join(f"<p>{escape(line)}</p>" for line in words.verdict(model, runs, horizon))
    warned = "".join(f'<p class="warning">{escape(text)}</p>' for text in model.warnings)
    todo = words.advice(model, runs)
    following = (
        listing([escape(text) for text in todo], "advice")
        if todo
        else "<p>Nothing stands out: use the model within its envelope.</p>"
    )
    return f"""<header><h1>{escape(model.name)}</h1><p class="subtitle">Dynamic model, identified and
 put to the test</p></header>
<section id="verdict"><h2 class="quiet">Verdict</h2>
<div class="said">{said}</div>
<p class="sanity">{escape(words.sanity(model))}</p>
{warned}
<h3>What to do next</h3>
{following}</section>"""


def model(model: Model) -> str:
    """Equations, coefficients, least-squares steps."""
    named = listing([equation(model.structure, axis) for axis in range(3)], "equations")
    valued = listing([equation(model.structure, axis, model.values) for axis in range(3)], "equations")
    axes = "All values are in forward-left-up axes (<i>x</i> forward, <i>y</i> left, turning left is positive)"
    if model.vehicle.axes is Axes.FRD:
        axes += (
            "; the vehicle file and model.yaml are in forward-right-down axes, where some signs "
            "are opposite (last column)"
        )
    remark = ""
    if model.estimator.method == "equation-error":
        remark = """<p class="note">The standard errors are those of least squares: they cover scatter,
 also scatter that hangs together over time, but not the bias that pose noise causes. The poses are
 differentiated, so the regressors are noisy too, and that draws coefficients towards 0 by an amount
 that no interval here shows. R² is low because accelerations from differentiated poses are mostly
 noise; the predictions below are the measure of the model.</p>"""
    found = (
        f"<h3>How they were found</h3>{tables.steps(model)}{remark}" if model.estimator.steps else ""
    )
    return f"""<section id="model"><h2>Model</h2>
{named}
<p>With numbers (SI units, forces in command units):</p>
{valued}
<h3>Coefficients</h3>
<p class="note">{axes}. A coefficient is told apart from 0 when it is at least
 {words.TOLD_APART:g} standard errors away from it.</p>
{tables.coefficients(model)}
{found}</section>"""


def recorded(model: Model, runs: Sequence[Run]) -> str:
    """Track, faults, excitation and coverage of every recording."""
    parts = "\n".join(_recorded(run, i) for i, run in enumerate(runs))
    return f"""<section id="recorded"><h2>What was recorded</h2>
<p class="note">Left-out poses are not used anywhere; no velocity and no prediction reaches over a gap
 or a jump. The scatter plots show which speeds met which commands: the model knows the boat there,
 and guesses elsewhere.</p>
{parts}</section>"""


def prediction(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """Measured against predicted velocities, error histograms, autocorrelations."""
    parts = "\n".join(_prediction(run, i) for i, run in enumerate(runs))
    return f"""<section id="prediction"><h2>Prediction {horizon:g} s ahead</h2>
<p class="note">From every usable pose the model alone is driven for {horizon:g} s by the recorded
 commands; its velocity is drawn beside the measured one at that later instant. Error is measured minus
 predicted. The plots open at the busiest {WINDOW:g} s; drag over a stretch to zoom in, double-click to
 see the whole run. Histograms and autocorrelations are over the whole run. Predictions that start
 closer together than {horizon:g} s share what happened in between, so even a perfect model's errors
 hang together up to that lag (dotted line): only beyond it should they stay within the bands.</p>
{parts}</section>"""


def scores(runs: Sequence[Run], horizon: float) -> str:
    """Table III for all axes, and what its columns mean."""
    marked = (
        "<p class='note'>Marked: the axis that dominates a recording, the pairing of the paper's "
        "Table III.</p>"
        if any(run.score.excited for run in runs)
        else ""
    )
    return f"""<section id="scores"><h2>Scores {horizon:g} s ahead</h2>
{tables.scores(runs)}
{marked}<dl class="note">
<dt>stays constant</dt><dd>RMS error of assuming that the velocity {horizon:g} s later is what it is now:
 what one has without a model.</dd>
<dt>ratio</dt><dd>RMS error divided by that. Below 1 the model is worth having; 0.5 halves the error.
 It is only telling where the boat was driven.</dd>
<dt>floor</dt><dd>What a perfect model would score, because the velocities that it starts from and is
 compared with are themselves noisy. It holds for white pose noise.</dd>
<dt>excess</dt><dd>What is left of the RMS error without the floor, √(RMS² − floor²): the model's own
 part.</dd>
<dt>bias</dt><dd>Mean of measured minus predicted: wind, a current, an offset of the commands.</dd>
<dt>kurtosis</dt><dd>3 for a normal distribution; more means rare large errors.</dd>
<dt>(seen)</dt><dd>The model was identified from this recording, so its score flatters.</dd>
<dt>why errors are not white</dt><dd>Predictions start at every pose and reach {horizon:g} s ahead, so
 neighbours overlap. Errors of k-step predictions are a moving average of order k − 1 even for a perfect
 model: correlated below lag k, uncorrelated from there on.</dd>
</dl></section>"""


def provenance(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """Where everything comes from."""
    noise, step = model.noise, model.integration
    chosen = ", ".join(f"{k} = {v}" for k, v in model.estimator.settings.items()) or "none"
    facts = [
        ("seatrial", version("seatrial")),
        ("method", f"{model.estimator.method} (settings: {chosen})"),
        ("structure", model.structure.name),
        ("allocation", model.vehicle.scheme.value),
        ("axes", f"files {model.vehicle.axes.value}; in this report forward-left-up"),
        ("integration", f"{step.scheme}, step {number(step.step)} s"),
        ("pose noise", f"{number(1e3 * noise.position, 2)} mm, {number(1e3 * noise.heading, 2)} mrad"),
        ("horizon", f"{horizon:g} s"),
    ]
    lines = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in facts)
    chain = (
        f"<h3>Constants of the actuator chain</h3>{tables.constants(model)}"
        if model.vehicle.constants.names
        else "<p>The actuator chain has no constants: commands act at once and in full.</p>"
    )
    return f"""<section id="provenance"><h2>Provenance</h2>
<dl class="facts">{lines}</dl>
<h3>Files</h3>{tables.files(model, runs)}
{chain}
<h3>Envelope</h3><p class="note">Speeds from the 0.5th to the 99.5th percentile, commands from the lowest
 to the highest, of the recordings that the model was identified from.</p>{tables.envelope(model)}
</section>"""


def _recorded(run: Run, place: int) -> str:
    recording = run.recording
    rate = 1.0 / recording.period
    facts = (
        f"{minutes(recording.duration)}, {len(recording.t)} poses at {number(rate, 3)} Hz, "
        f"{100 * run.masked:.1f} % left out"
    )
    broken = "<p>No faults found.</p>"
    if recording.faults:
        count = len(recording.faults)
        every = f'<details class="fine"><summary>every fault ({count})</summary>{tables.faults(run)}</details>'
        broken = tables.fault_kinds(run) + every
    cover = "".join(
        _plot(place, f"coverage-{s}", f"{a} speed against command", "small")
        for a, s in zip(AXES, SYMBOLS, strict=True)
    )
    inside = f"""<div class="pair">{_plot(place, "track", "track of the boat", "square")}
<div>{tables.excitations(run)}{broken}</div></div>
<div class="three">{cover}</div>"""
    return _foldable(recording.name, facts, inside, place)


def _prediction(run: Run, place: int) -> str:
    sizes = []
    for axis, sign in enumerate(SYMBOLS):
        name, scale = UNITS[axis]
        sizes.append(f"{sign} {number(run.score.scores[sign].rms * scale, 2)} {name}")
    facts = f"{'unseen' if run.unseen else 'seen'}; RMS error " + ", ".join(sizes)
    whole = f"{run.t[0]:.6g},{run.t[-1]:.6g}"
    window = f"{run.window[0]:.6g},{run.window[1]:.6g}"
    buttons = "".join(
        f'<button type="button" data-do="{do}">{label}</button>'
        for do, label in (
            ("whole", "whole run"), ("window", f"{WINDOW:g} s"), ("earlier", "‹ earlier"),
            ("later", "later ›"),
        )
    )  # fmt: skip
    inside = (
        f'<div class="linked" data-whole="{whole}" data-window="{window}">'
        f'<div class="bar">{buttons}</div>'
        + "".join(_axis(run, place, axis) for axis in range(3))
        + "</div>"
    )
    return _foldable(run.recording.name, facts, inside, place)


def _axis(run: Run, place: int, axis: int) -> str:
    sign, (name, scale) = SYMBOLS[axis], UNITS[axis]
    found = run.score.scores[sign]
    told = f"RMS {number(found.rms * scale, 2)} {name}, kurtosis {number(found.kurtosis, 2)}"
    label = f"{AXES[axis]} velocity"
    return f"""<h4>{AXES[axis].capitalize()} <i>{sign}</i></h4>
<div class="axis">{_plot(place, f"velocity-{sign}", f"{label}, measured and predicted", "wide")}
<div>{_plot(place, f"histogram-{sign}", f"histogram of the {label}'s errors", "small", told)}
{_plot(place, f"autocorrelation-{sign}", f"autocorrelation of the {label}'s errors", "small")}</div></div>"""


def _plot(place: int, figure: str, label: str, size: str, caption: str = "") -> str:
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return (
        f'<figure>{below}<div class="plot {size}" data-run="run-{place}" data-figure="{figure}" '
        f'role="img" aria-label="{escape(label)}"></div></figure>'
    )


def _foldable(name: str, facts: str, inside: str, place: int) -> str:
    opened = " open" if place == 0 else ""
    return f"""<details class="run"{opened}><summary><b>{escape(name)}</b> <span>{escape(facts)}</span></summary>
{inside}</details>"""
