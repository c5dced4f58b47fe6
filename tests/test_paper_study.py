# SPDX-License-Identifier: MIT
"""The study of the paper's findings: what it runs, and how its page is made."""

import numpy as np
import pytest

from benchmarks.studies.paper import coupling, maps, open_points, page, tables
from benchmarks.studies.paper.grid import Grid, draw
from benchmarks.studies.paper.trials import boat, changed
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import FileError


def cell(mp, af, edge=0.08, seed=1):
    """Results of one cell of the map, MP and AF."""
    found = {"MP": mp, "AF": af}
    return [
        {
            "finding": "maps",
            "key": [edge, "small", "none", a, seed],
            "found": {
                m: None if v is None else {"paired": [v] * 3, "unseen": [v] * 3, "true": [v] * 3}
                for m, v in zip(maps.METHODS, values, strict=True)
            },
        }
        for a, values in found.items()
    ]


def test_ratios_are_geometric_means_over_seeds_in_which_both_were_found():
    records = [
        *cell((2.0, 1.0), (1.0, 1.0)),
        *cell((8.0, 1.0), (1.0, 1.0), seed=2),
        *cell((None, 3.0), (1.0, 1.0), seed=3),
    ]
    grid = page.ratio_grids(records, "equation-error")[0]
    at = list(maps.EDGES).index(0.08)
    assert grid.cells[at][0] == pytest.approx(4.0)
    assert np.isnan(grid.cells[0][0])
    ours = page.ratio_grids(records, "output-error")[0]
    assert ours.cells[at][0] == pytest.approx(3.0 ** (1 / 3))


def test_the_page_keeps_its_words_and_gets_its_tables(tmp_path):
    path = tmp_path / "paper.md"
    path.write_text("before\n\n<!-- nearest -->\nold\n<!-- end -->\n\nafter\n")
    page.write(cell((0.03, 0.01), (0.02, 0.01)), path)
    text = path.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert "| nearest in levels | 0.08 | small | none |" in text
    assert (tmp_path / "images" / "map-paper.svg").read_text().count("<rect") == 1 + 3 * 15
    path.write_text("<!-- weather -->\n<!-- end -->\n")
    with pytest.raises(FileError, match="no table weather; there are table-two"):
        page.write([], path)


def test_worse_under_mp_is_orange_and_better_is_blue(tmp_path):
    draw([Grid("t", ["a"], ["x", "y", "z"], [[2.0, 1.0, 0.5]])], tmp_path / "g.svg")
    drawn = (tmp_path / "g.svg").read_text()
    red = [int(part.split(",")[0]) for part in drawn.split('fill="rgb(')[1:]]
    assert red[0] > 200 > red[2]
    assert red[1] == 255


def test_the_plan_and_the_boat_change_together():
    plan = changed(load_plan("paper-like"), edge=0.12, amplitude=(0.1, 0.4), noise=(0.001, 0.002))
    zone = plan.plant.chain[0].dead_zone
    assert zone is not None
    assert (zone.forward, zone.reverse) == (0.12, 0.12)
    assert set(plan.operator.amplitude.values()) == {(0.1, 0.4)}
    assert (plan.pose.position_noise, plan.pose.heading_noise) == (0.001, 0.002)
    assert boat("AF", 0.12).to_mapping()["allocation"]["F_os"] == pytest.approx(0.16)
    assert changed(load_plan("paper-like"), edge=0.0).plant.chain[0].dead_zone is None


@pytest.mark.system
def test_one_boat_goes_through_all_of_the_paper():
    found = tables.work("paper-like", "AF", 1)
    for name, printed in tables.PRINTED.items():
        assert found["output-error"]["coefficients"][name] == pytest.approx(
            printed[1] / (0.92 if name.endswith("_F") else 1.0), abs=0.03
        )
    steps = found["output-error"]["steps"]
    assert steps == 15
    assert tables.beyond(found["output-error"]["rho"][0], steps) < 0.2
    for ours, papers in zip(*(found[m]["unseen"] for m in reversed(tables.METHODS)), strict=True):
        assert ours < papers


def test_eq_17_taken_literally_loses_the_coupling_and_a_true_model_is_at_its_floor():
    found = open_points.work("paper-like", "AF", 1)
    assert found["literal"][1] < 0.8 * found["simultaneous"][1] < 0.63  # N_uu
    np.testing.assert_allclose(found["rms"], found["floor"], rtol=0.1)
    assert min(found["white"]) > max(found["beyond"])


def test_without_its_terms_a_model_does_not_turn():
    vehicle = boat("AF")
    bare = coupling.without(vehicle, ("N_ud", "N_uu"))
    assert set(vehicle.structure.coefficients) - set(bare.structure.coefficients) == {
        "N_ud",
        "N_uu",
    }
