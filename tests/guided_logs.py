# SPDX-License-Identifier: MIT
"""Logs of a survey boat for the guided path, and someone who answers."""

import numpy as np
import pytest
from sheets import sheet
from survey_boat import driven

LEVER, CURRENT = (0.30, -0.12), (0.05, -0.04)  # [m], [m/s]
SECONDS = 480.0


def tables(folder, recording, *, lever=(0.0, 0.0), current=(0.0, 0.0), flip=False):
    """The recording as a folder of tables, of a point off the origin and in a current."""
    eta, t = recording.eta, recording.t
    c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
    x = eta[:, 0] + c * lever[0] - s * lever[1] + current[0] * t
    y = eta[:, 1] + s * lever[0] + c * lever[1] + current[1] * t
    folder.mkdir(parents=True)
    psi = eta[:, 2] + (np.pi if flip else 0.0)
    sheet(folder / "poses.csv", "t,x,y,psi", t + 100.0, x, y, psi, form="%.6f")
    own = recording.commands
    stamps = (own.stamps - recording.stamps[0]) * 1e-9 + 100.0
    sheet(folder / "commands.csv", "t,left,right", stamps, own.values, form="%.6f")
    return folder


def one_drive(seconds=SECONDS, seed=1):
    """The survey boat, driven by two thrusters."""
    size = lambda g: g.uniform(-1, 1)  # noqa: E731
    return driven({}, [size, size], seconds=seconds, seed=seed)[1]


class Owner:
    """Someone who knows the boat: answers by question, and all questions that came."""

    def __init__(self, **answers):
        self.answers, self.asked = answers, []

    def choose(self, question, options):
        """The answer, or the usual one."""
        self.asked.append(question)
        found = [a for key, a in self.answers.items() if key in question]
        assert not found or found[0] in options
        return found[0] if found else options[0]

    def text(self, question):
        """The answer, or that it is not known."""
        self.asked.append(question)
        return next((a for key, a in self.answers.items() if key in question), "")


@pytest.fixture(scope="module")
def lake_log(tmp_path_factory):
    """Of a boat in a current, its antenna off the origin: a fixture of modules that name it `drive`."""
    folder = tmp_path_factory.mktemp("logs") / "lake"
    return tables(folder, one_drive(), lever=LEVER, current=CURRENT)
