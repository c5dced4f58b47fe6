# SPDX-License-Identifier: MIT
"""Equations and names as mathematics: MathML, text and LaTeX say what the structure says."""

import re
from html import unescape
from xml.etree import ElementTree

import pytest
from conftest import TABLE_II, make_model

from seatrial.boat.structure import Force, parse
from seatrial.report.text.equations import equations
from seatrial.report.text.names import (
    html_symbol,
    latex_symbol,
    mathml_symbol,
    names_in,
    plotly_symbol,
    sentence,
)

ODD = {"surge": ["2 * v * r", "X_u * u"], "sway": ["- u * r", "0.5"], "yaw": []}
CORE = {"math", "mi", "mn", "mo", "mtext", "msub", "mover"}  # of MathML Core: what browsers know


@pytest.fixture(scope="module")
def models(mp, cse1_vehicle):
    names = cse1_vehicle.structure.coefficients
    values = {name: (-1.0) ** i * 10.0 ** (i % 4 - 7) * 1.234567 for i, name in enumerate(names)}
    return [make_model(mp, TABLE_II["MP"]), make_model(cse1_vehicle, values)]


def read_back(node: ElementTree.Element) -> str:
    """MathML as the plain text of files."""
    parts = [read_back(child) for child in node]
    if node.tag == "msub":
        return f"{parts[0]}_{parts[1]}"
    if node.tag == "mover":
        assert parts[1] == "\u02d9"
        return f"{parts[0]}_dot"
    if parts:
        return " ".join(parts).replace("\u2062", " ")
    return node.text.replace("−", "-")


def plain(line: str) -> list[str | float]:
    """Words, signs and numbers."""
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    line = re.sub(r"·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda m: f"e{m[1].translate(digits)}", line)
    line = re.sub(r"\|\s*(\w)\s*\|", r"|\1|", line)
    words = re.sub(r"(?<![\de])-(?=\S)", "- ", line).split()
    return [float(w) if re.match(r"[\d.]", w) else w for w in words]


def drawn(text: str) -> list[str]:
    """Every equation as its title and what its MathML reads."""
    found = re.findall(r'<div class="equation" title="([^"]*)">(.*?)</div>', text)
    out = []
    for title, inside in found:
        root = ElementTree.fromstring(f"<r>{inside}</r>")
        assert {e.tag for e in root.iter()} - {"r", "span"} <= CORE
        assert plain(read_back(root)) == plain(unescape(title))
        out.append(unescape(title))
    return out


def test_mathml_reads_as_the_structure_says(models):
    for model in models:
        for values in (None, model.values):
            expected = [model.structure.equation(axis, values) for axis in range(3)]
            text = equations(model.structure, values)
            assert drawn(text) == expected
            pre = re.findall(r"<pre[^>]*>(.*?)</pre>", text, re.DOTALL)
            assert unescape(pre[0]).split("\n") == expected


def test_signs_numbers_and_an_equation_without_terms():
    structure = parse("odd", ODD, [Force("F_u", 0)])
    text = equations(structure)
    assert drawn(text) == ["u_dot = 2 v r + X_u u", "v_dot = -u r + 0.5", "r_dot = 0"]
    assert text.count("<mn>0</mn>") == 1
    assert text.count("<math>") == 3 + 2 + 2 + 1


def test_latex_has_every_term(models):
    text = equations(models[0].structure, models[0].values)
    lines = unescape(re.findall(r"<pre[^>]*>(.*?)</pre>", text, re.DOTALL)[1]).split("\n")
    assert lines[0] == (
        r"\dot u &= v \, r - 0.1000 \, u - 1.670 \, |u| \, u + 0.1500 \, F_{\mathrm{u}} \\"
    )
    assert len(lines) == 3 and not lines[2].endswith("\\")


@pytest.mark.parametrize(
    ("name", "html", "plotly", "latex"),
    [
        ("X_uu", "<i>X</i><sub>uu</sub>", "X<sub>uu</sub>", r"$X_{\mathrm{uu}}$"),
        ("u_dot", "<i>u\u0307</i>", "u\u0307", r"$\dot u$"),
        ("|u|", "|<i>u</i>|", "|u|", "$|u|$"),
        ("v", "<i>v</i>", "v", "$v$"),
        ("lag.bow", "lag.<wbr>bow", "lag.bow", "lag.bow"),
        ("pair_offset.a", "pair_<wbr>offset.<wbr>a", "pair_offset.a", r"pair\_offset.a"),
        ("edge_forward", "edge_<wbr>forward", "edge_forward", r"edge\_forward"),
        ("F_<b>", "<i>F</i><sub>&lt;b&gt;</sub>", "F<sub>&lt;b&gt;</sub>", r"$F_{\mathrm{$<$b$>$}}$"),
    ],
)  # fmt: skip
def test_a_name_has_one_meaning_in_every_dress(name, html, plotly, latex):
    assert html_symbol(name) == html
    assert plotly_symbol(name) == plotly
    assert latex_symbol(name) == latex
    assert ElementTree.fromstring(f"<r>{mathml_symbol(name)}</r>") is not None


def test_a_sentence_shows_names_and_minus(models):
    names = names_in(*models)
    assert {"X_uu", "F_u", "N_d"} <= set(names)
    said = sentence("X_u (-0.83, 4e+02): X_us, run-1 <b>, lag.F_u, F_u.", names)
    assert said == (
        "<i>X</i><sub>u</sub> (−0.83, 4.0·10²): X_us, run-1 &lt;b&gt;, lag.F_u, <i>F</i><sub>u</sub>."
    )
    assert sentence("X_u", []) == "X_u"
