# SPDX-License-Identifier: MIT
"""The first screen's scores, the table of effects, and a boat without sway thrust."""

import re
from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from conftest import make_model
from survey_boat import LAG, LATENCY, TRUTH, boat, driven

from seatrial.boat.earth_effects import direction, earth_effects
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import RecordingEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.evaluation.comparison.cause_candidates import BATTERY, CURRENT, MASS, ONE_THRUSTER
from seatrial.evaluation.comparison.causes import Cause
from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.comparison.console import WHAT_TO_DO, next_text
from seatrial.identification.console import summary
from seatrial.report.evidence.first_screen import floor_score, known_score
from seatrial.report.evidence.model_evidence import collect
from seatrial.report.evidence.runs import judged
from seatrial.report.evidence.verdict import headline
from seatrial.report.figures.dials import part_dial, share_dial
from seatrial.report.html import page
from seatrial.report.sections import all_sections, effects
from seatrial.report.sections.verdict import dials
from seatrial.util.frames import AXES
from seatrial.util.statistics import NORMAL_95


def pushes(rng):
    return rng.choice([-1, 1]) * rng.uniform(0.2, 1.0)


@pytest.fixture(scope="module")
def survey():
    """Two thrusters astern: no sway thrust. Its true model, and a minute of driving."""
    _, recording = driven({}, (pushes, pushes), seconds=60.0, seed=5)
    return make_model(boat([{"latency": LATENCY, "lag": LAG}]), TRUTH), recording


@pytest.fixture(scope="module")
def evidence(survey):
    model, recording = survey
    return collect(model, [recording], 1.0)


@pytest.fixture(scope="module")
def sections(evidence):
    return all_sections(evidence)


def test_a_boat_without_sway_thrust_has_no_empty_plots(sections):
    drawn = {name: f for s in sections for own in s.figures.values() for name, f in own.items()}
    for name, figure in drawn.items():
        assert figure["data"], name
        assert figure["layout"].get("showlegend") is True, name
        for axis in (key for key in figure["layout"] if key.startswith("yaxis")):
            own = [t for t in figure["data"] if t.get("yaxis", "y") == axis.replace("axis", "")]
            assert any(np.isfinite(np.asarray(t["y"], dtype=float)).any() for t in own), (
                name,
                axis,
            )
    for kind in ("cells", "coverage", "command"):
        assert {f"{kind}-u", f"{kind}-r"} <= set(drawn)
        assert f"{kind}-v" not in drawn
    text = page("x", sections)
    assert set(re.findall(r'data-figure="([^"]+)"', text)) == set(drawn)


def test_the_picture_shows_the_driven_axes_and_the_busiest_minute(sections, evidence):
    picture = sections[0].figures["all"]["picture"]
    titles = [picture["layout"][key]["title"]["text"] for key in ("yaxis", "yaxis2")]
    assert titles == ["u [m/s]", "r [rad/s]"]
    assert "yaxis3" not in picture["layout"]
    assert [t["name"] for t in picture["data"] if t["showlegend"]] == ["measured", "predicted"]
    begin, end = picture["layout"]["xaxis"]["range"]
    assert end - begin == pytest.approx(min(60.0, evidence.runs[0].t[-1]))


def test_the_way_to_the_floor(evidence):
    """0 is constant velocity's error, 1 the floor's, both without the floor."""
    found = floor_score(evidence.runs)
    (run,) = judged(evidence.runs)
    score = run.score.scores["v"]
    still = np.sqrt(score.stays_constant**2 - score.floor**2)
    own = 0.0 if score.at_floor else np.sqrt(max(score.rms**2 - score.floor**2, 0.0))
    assert found.share[1] == pytest.approx(1.0 - own / still, abs=0.05)
    assert found.over_floor[0] == pytest.approx(
        run.score.scores["u"].rms / run.score.scores["u"].floor, rel=1e-6
    )
    assert found.still_over_floor[0] == pytest.approx(
        run.score.scores["u"].stays_constant / run.score.scores["u"].floor, rel=1e-6
    )
    assert found.worst == int(np.argmin(found.share))


def test_the_share_of_known_parameters(evidence):
    """`make_model` knows every coefficient to 10 %: usable."""
    found = known_score(evidence.known)
    assert (found.sharp, found.usable, found.estimated) == (0, 10, 10)
    assert found.share == 1.0


def test_the_dials_say_in_text_what_they_draw(evidence):
    floor, known, uses = (dial.html() for dial in dials(evidence))
    found = floor_score(evidence.runs)
    worst = found.worst
    assert found.still_over_floor[worst] > 1000.0 > found.over_floor[worst]
    assert (
        f"%, less error beyond the noise floor than constant velocity; worst: {AXES[worst]}, "
        f"{found.over_floor[worst]:.2g} against &gt; 1000 × floor" in floor
    )
    assert (
        'aria-label="What is known: 100 %, of 10 parameters are sharp (0) or usable (10)"' in known
    )
    levels = ", ".join(f"{one.use.value} {one.level.value}" for one in evidence.fitness)
    assert levels in uses
    assert len(re.findall(r'class="arc (good|fair|poor)"', uses)) == 3


@pytest.mark.parametrize(
    ("share", "grade"), [(0.81, "good"), (0.79, "fair"), (0.51, "fair"), (0.49, "poor")]
)
def test_a_share_is_an_arc_of_its_length(share, grade):
    text = share_dial("x", "X", share, "of it", (0.8, 0.5)).html()
    end = re.search(rf'class="arc {grade}" d="M12.00 58.00A48 48 0 0 1 ([\d.-]+) ([\d.-]+)"', text)
    angle = np.arctan2(58.0 - float(end[2]), float(end[1]) - 60.0)
    assert 1.0 - angle / np.pi == pytest.approx(share, abs=1e-3)
    assert f">{100 * share:.0f} %<" in text


def test_parts_have_a_grade_each():
    text = part_dial("x", "X", "2 of 3", "so", ["good", "poor", "good"]).html()
    assert re.findall(r'"arc (\w+)"', text) == ["none", "good", "poor", "good"]


def test_the_headline_names_recordings_and_uses(evidence):
    text = headline(evidence)
    assert "1\u00a0s ahead on drive, which it has not seen." in text
    for one in evidence.fitness:
        assert one.use.value in text.partition("not seen. ")[2]


def test_effects_have_their_intervals(survey):
    model, _ = survey
    entry = RecordingEntry(
        "S1", 60.0, effects={"current_x": 0.05, "wind_y": 0.001}, errors={"current_x": 0.01, "wind_y": 0.002}
    )  # fmt: skip
    found = [
        finding_of(FindingKind.LEVER_ARM_ERRORS, ahead=0.01, aside=0.02),
        finding_of(FindingKind.DELAY, "position", delay=0.1, error=0.03),
        finding_of(FindingKind.UNMODELLED_WIND),
    ]
    estimator = msgspec.structs.replace(model.estimator, findings=found)
    known = replace(
        model, recordings=(entry,), estimator=estimator, vehicle=model.vehicle.with_lever((0.25, -0.03))
    )  # fmt: skip
    rows = [[cell.plain() for cell in row] for row in effects.effects(known).rows]
    assert [row[0] for row in rows] == [
        "lever arm ahead", "lever arm to port", "delay of position", "current along x", "wind along y",
    ]  # fmt: skip
    lever, aside, delay, current, wind = rows
    assert lever[4] == f"{0.25 - NORMAL_95 * 0.01:.10g} to {0.25 + NORMAL_95 * 0.01:.10g}"
    assert [row[-1] for row in (lever, aside, delay, current, wind)] == [
        "significant", "not distinguishable from zero", "significant", "significant",
        "not distinguishable from zero",
    ]  # fmt: skip
    assert (current[1], current[5], wind[5]) == ("S1", "m/s", "m/s^2")
    assert float(current[3]) == pytest.approx(NORMAL_95 * 0.01)
    text = effects.section(SimpleNamespace(model=known)).html
    assert "unmodelled effect: wind" in text


@pytest.fixture
def in_a_current(survey):
    """The survey boat in a current to the south-west, forward-right-down with latitude and longitude."""
    content = survey[0].vehicle.to_mapping() | {"axes": "forward-right-down"}
    content["pose"] = {"latitude": "lat", "longitude": "lon", "psi": "psi"}
    entry = RecordingEntry(
        "S1", 60.0, effects={"current_x": -0.03, "current_y": 0.04}, errors={"current_x": 0.001, "current_y": 0.002}
    )  # fmt: skip
    return replace(
        survey[0],
        recordings=(entry,),
        vehicle=vehicle_from(content, "frd").with_lever((0.25, -0.03)),
        estimator=msgspec.structs.replace(
            survey[0].estimator,
            findings=[finding_of(FindingKind.LEVER_ARM_ERRORS, ahead=0.01, aside=0.02)],
        ),
    )


def test_a_current_has_a_size_and_a_bearing(in_a_current):
    """x of the model is north, y to its left is west."""
    (found,) = earth_effects(in_a_current.vehicle, in_a_current.recordings[0])
    assert (found.kind, found.unit, found.direction) == ("current", "m/s", "233 deg (south-west)")
    assert found.size == pytest.approx(0.05)
    assert found.error == pytest.approx(np.hypot(0.6 * 0.001, 0.8 * 0.002))
    rows = [[cell.plain() for cell in row] for row in effects.effects(in_a_current).rows]
    assert [row[0] for row in rows][-1] == "current toward 233 deg (south-west)"
    assert "S1: current of 0.0500 ± 0.0017 m/s toward 233 deg (south-west)" in summary(in_a_current)


@pytest.mark.parametrize(
    ("axes", "pose", "said"),
    [
        ("forward-left-up", {"x": "east", "y": "north"}, "37 deg (north-east)"),
        ("forward-left-up", {"x": "pos_e", "y": "pos_n"}, "37 deg (north-east)"),
        ("forward-right-down", {"x": "UTM north", "y": "UTM east"}, "307 deg (north-west)"),
        ("forward-left-up", {"x": "pose", "y": "other"}, "53 deg from x towards y"),
        ("forward-left-up", {}, "53 deg from x towards y"),
        ("forward-right-down", {}, "-53 deg from x towards y"),
    ],
)
def test_a_direction_is_in_the_words_of_the_files_axes(survey, axes, pose, said):
    content = survey[0].vehicle.to_mapping() | {"axes": axes, "pose": pose}
    assert direction(vehicle_from(content, "own"), 0.3, 0.4) == said


def test_a_direction_along_x_has_no_sign(survey):
    assert direction(survey[0].vehicle, 1.0, -1e-3) == "0 deg from x towards y"


def test_the_first_screen_has_the_effects_on_one_line(in_a_current, survey):
    line = effects.in_short(in_a_current)
    assert line == (
        "lever arm ahead 0.250 ± 0.020 m; lever arm to port -0.030 ± 0.039 m; "
        "current 0.0500 ± 0.0033 m/s toward 233 deg (south-west)"
    )
    assert effects.in_short(survey[0]) == ""


def test_without_any_effect_there_is_no_section(evidence):
    assert effects.section(evidence) is None


def test_the_next_step_follows_the_cause(mp):
    from conftest import TABLE_II

    heavier = {name: value / 1.2 for name, value in TABLE_II["MP"].items()}
    a, b = make_model(mp, TABLE_II["MP"]), make_model(mp, heavier)
    found = compare(a, b)
    assert next_text(found) == "give recordings, to test whether the change matters for prediction"

    def after(*causes):
        own = [Cause(c, p, -0.1, "F_1", log) for c, p, log in causes]
        better = {"1": {"u": "B", "v": None, "r": "B"}}
        return next_text(msgspec.structs.replace(found, better=better, causes=own))

    assert after((MASS, 0.9, 0.0)) == WHAT_TO_DO[MASS]
    assert after((CURRENT, 0.9, 0.0)) == WHAT_TO_DO[CURRENT]
    assert after((ONE_THRUSTER, 0.9, 0.0)) == "look for weeds or damage at thruster F_1"
    assert "battery voltage, and look for weeds" in after(
        (BATTERY, 0.5, 0.0), (ONE_THRUSTER, 0.5, 0.0)
    )
    assert after((MASS, 0.4, 0.0)) == "use B, which predicts these recordings better"
