# SPDX-License-Identifier: MIT
"""The C++ reader of model files beside Python's: the same predictor, the same signals, as clear words."""

import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml
from board_boats import VEHICLES, identified
from conftest import ROOT
from cpp_tools import built, run
from programs import piped
from recording_tools import in_vehicle_terms

import seatrial
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import TO_SI, as_column
from seatrial.io.poses import pose_columns
from seatrial.io.signals import scaled
from seatrial.onboard.parameter_uncertainty import onboard_uncertainty
from seatrial.onboard.predictor import Estimate, Predictor
from seatrial.util.errors import SeatrialError

pytestmark = pytest.mark.system
MODELS_OF_THEN = sorted((ROOT / "tests" / "models").glob("*-model-2.yaml"))


def events(model: seatrial.Model, seed: int) -> list[tuple[str, list[float]]]:
    """Commands, scales and poses of a drive, some late, with a false match; and when to look."""
    random = np.random.default_rng(seed)
    ghost, found = Predictor(model), []

    def put(kind: str, *row: float) -> None:
        found.append((kind, [float(x) for x in row]))

    ghost.pose(0.0, np.zeros(3))
    for i in range(160):
        t = 0.05 * i
        if i % 12 == 0:
            stick = random.uniform(-0.9, 0.9, len(model.vehicle.inputs))
        if i % 90 < 70:  # then silence
            ghost.command(t, stick)
            put("command", t, *stick)
        if model.vehicle.scales and i % 30 == 5:
            level = [
                s.reference * random.uniform(0.8, 1.1) for s in model.vehicle.file.scales.values()
            ]
            ghost.scale(t, level)
            put("scale", t, *level)
        late = t - random.choice([0.0, 0.2, 0.7])
        pose = ghost.at(late).pose + random.normal(0.0, 0.004, 3) + (i in (40, 41))
        put("pose", late, *pose)
        put("at", t + random.choice([-0.3, 0.0, 0.4]))
    return found


def flat(now: Estimate) -> np.ndarray:
    head = [now.time, now.health.value]
    return np.concatenate([head, now.pose, now.velocity, now.disturbance, now.covariance.ravel()])


def follow(model: seatrial.Model, script: list[tuple[str, list[float]]]) -> np.ndarray:
    """What Python's predictor says, a row for each look."""
    predictor, rows = Predictor(model), []
    for kind, (t, *values) in script:
        if kind == "at":
            rows.append(flat(predictor.at(t)))
        else:
            getattr(predictor, kind)(t, values)
    return np.array(rows)


@dataclass(frozen=True)
class Program:
    path: Path

    def says(self, *arguments: object) -> list[list[str]]:
        return [line.split() for line in run(str(self.path), *map(str, arguments)).splitlines()]

    def complaint(self, path: Path) -> str:
        done = piped([self.path, "noise", path])
        assert (done.returncode, done.stdout) == (1, "")
        return done.stderr


@pytest.fixture(scope="module")
def program() -> Program:
    """The reader with the predictor, under the sanitizers."""
    return Program(built("board_model"))


@pytest.fixture(scope="module", params=VEHICLES)
def written(request, tmp_path_factory) -> tuple[seatrial.Model, Path]:
    """A model as Python reads it, and its file."""
    seed = list(VEHICLES).index(request.param)
    path = tmp_path_factory.mktemp("written") / "model.yaml"
    save(identified(VEHICLES[request.param](), seed), path)
    return load(path), path


def floats(words: list[str]) -> np.ndarray:
    return np.array([float.fromhex(w) if "x" in w or "n" in w else float(w) for w in words])


def test_the_predictor_says_the_same_to_the_last_bits(program, written, tmp_path):
    model, path = written
    script = events(model, 7)
    lines = [" ".join([kind, *(x.hex() for x in row)]) for kind, row in script]
    (tmp_path / "events.txt").write_text("\n".join(lines))
    mine = np.array([floats(row) for row in program.says("follow", path, tmp_path / "events.txt")])
    theirs = follow(model, script)
    assert mine.shape == theirs.shape == (160, 2 + 9 + 36)
    assert np.array_equal(mine[:, :2], theirs[:, :2])  # time, health
    assert np.ptp(theirs[:, 5]) > 0.02  # it moved
    sigma = np.sqrt(np.einsum("nii->ni", theirs[:, 11:].reshape(-1, 6, 6)))
    size = np.einsum("ni,nj->nij", sigma, sigma).reshape(-1, 36)
    assert np.all(np.abs(mine[:, 11:] - theirs[:, 11:]) <= 1e-11 * size)
    np.testing.assert_allclose(mine[:, 2:11], theirs[:, 2:11], rtol=1e-11, atol=1e-13)
    if not model.vehicle.file.thrusters:  # whose geometry numpy inverts by other sums
        assert np.array_equal(mine, theirs)


def test_the_noise_on_board_is_pythons(program, written):
    model, path = written
    (row,) = program.says("noise", path)
    believed = onboard_uncertainty(model).noise
    np.testing.assert_allclose(floats(row), believed, rtol=1e-12)


@pytest.mark.parametrize("path", MODELS_OF_THEN, ids=lambda path: path.stem)
def test_a_model_of_then_is_read_as_the_one_that_is_written_of_it(program, path, tmp_path):
    """With sentences in place of findings, which a node reads neither of."""
    save(load(path), tmp_path / "new.yaml")
    assert "seatrial: model 3" in (tmp_path / "new.yaml").read_text()
    for what in ("noise", "signals"):
        assert program.says(what, path) == program.says(what, tmp_path / "new.yaml")


def value(words: list[str], raw: float) -> float:
    gain, offset = floats(words[-2:])
    return gain * raw + offset


def test_commands_and_scales_are_read_as_from_bags(program, written):
    model, path = written
    file = model.vehicle.file
    rows = program.says("signals", path)
    assert rows[0] == ["name", model.name]
    assert rows[1] == ["commands", f"topic={file.commands.topic or ''}", f"clock={file.commands.clock}"]  # fmt: skip
    given = [(*entry, sign) for entry, sign in zip(file.commands.inputs.items(), model.vehicle.input_signs, strict=True)]  # fmt: skip
    given += [(name, scale.column, 1.0) for name, scale in file.scales.items()]
    shown = [row for row in rows if row[0] in ("input", "scale")]
    for (name, entry, sign), row in zip(given, shown, strict=True):
        column = as_column(entry)
        assert row[1] == name
        assert row[2] == f"topic={column.topic or file.commands.topic or ''}"
        field, index = row[3].removeprefix("field="), row[4].removeprefix("index=")
        expected = column.field if column.index is None else f"{column.field}[{column.index}]"
        assert (field if index == "-1" else f"{field}[{index}]") == expected
        for raw in (-1.0, 0.3, 1620.0):
            assert value(row, raw) == pytest.approx(sign * scaled(np.array([raw]), column)[0])


@pytest.mark.parametrize("turned", [False, True])
def test_poses_are_read_as_from_bags(program, written, turned):
    """Of a point at the lever, in SI and forward-left-up: less the lever it is the boat's origin."""
    model, path = written
    vehicle, spec = model.vehicle, model.vehicle.file.pose
    rows = program.says("signals", path)
    (source,) = [row for row in rows if row[:2] != ["pose", "x"] and row[0] == "pose" and "topic=" in row[1]]  # fmt: skip
    assert source[1:5] == [f"topic={spec.topic or ''}", f"parent={spec.parent or ''}", f"child={spec.child or ''}", f"clock={spec.clock}"]  # fmt: skip
    x, y, psi, heading = [
        row for row in rows if row[0] in ("pose", "heading") and row is not source
    ]
    raw, yaw = np.array([1.2, -0.7, 0.5]), 0.8
    if turned:  # a quaternion
        raw[2] = yaw / TO_SI[pose_columns(vehicle)[2].unit or "rad"]
    eta = [
        value(x, raw[0]),
        value(y, raw[1]),
        value(heading, yaw) if turned else value(psi, raw[2]),
    ]
    ahead, left = floats(source[5:])
    c, s = np.cos(eta[2]), np.sin(eta[2])
    origin = [eta[0] - c * ahead + s * left, eta[1] - s * ahead - c * left, eta[2]]
    np.testing.assert_allclose(
        origin, in_vehicle_terms(raw[None], vehicle)[0], rtol=1e-12, atol=1e-15
    )


@pytest.fixture(scope="module")
def ship(tmp_path_factory) -> str:
    """A file that is right."""
    path = tmp_path_factory.mktemp("ship") / "model.yaml"
    save(identified(VEHICLES["cse1 pair"](), 0), path)
    return path.read_text()


@pytest.fixture(scope="module")
def right(ship) -> dict:
    return yaml.safe_load(ship)


@pytest.fixture
def content(right) -> dict:
    """What is in it, to be spoiled."""
    return copy.deepcopy(right)


BAD = [
    (lambda c: c.update(seatrial="model 1"), "says 'seatrial: model 1'; expected 'seatrial: model 3'"),
    (lambda c: c.pop("seatrial"), "has no line 'seatrial: ...'; expected 'seatrial: model 3'"),
    (lambda c: c.pop("noise"), "key 'noise' is missing"),
    (lambda c: c["vehicle"].pop("commands"), "vehicle: key 'commands' is missing"),
    (lambda c: c.update(colour="red"), "unknown key 'colour'"),
    (lambda c: c["vehicle"].update(axis="x"), "vehicle: unknown key 'axis'"),
    (lambda c: c["vehicle"]["pose"].update(topik="/x"), "vehicle.pose: unknown key 'topik'"),
    (lambda c: c["structure"]["surge"].append("X_w * w"), "structure.surge[6]: term 'X_w * w' has factor 'w'"),
    (lambda c: c["structure"]["surge"].append("X_u * u_dot"), "own axis' acceleration"),
    (lambda c: c["structure"]["surge"].append("X_u * u + X_v * v"), "is a sum"),
    (lambda c: c["structure"]["surge"].append("X_u * u * u * u * u * u"), "factors"),
    (lambda c: c["structure"]["sway"].append("X_u * u"), "X_u stands in two terms"),
    (lambda c: c["coefficients"].pop("X_u"), "X_u"),
    (lambda c: c["coefficients"].update(Y_x={"value": 1.0, "standard_error": 1.0}), "Y_x"),
    (lambda c: c["coefficients"]["X_u"].update(value="fast"), "coefficients.X_u.value: got 'fast'"),
    (lambda c: c["coefficients"]["X_u"].update(value="1.0"), "coefficients.X_u.value: got '1.0'"),
    (lambda c: c["coefficients"]["X_u"].update(value=float("nan")), "coefficients.X_u.value: got '.nan'"),
    (lambda c: c["constants"].pop("latency.bow"), "latency.bow"),
    (lambda c: c["covariance"].pop(), "covariance: must be"),
    (lambda c: c["covariance"][0].__setitem__(0, -1.0), "covariance: must be symmetric with variances >= 0"),
    (lambda c: c["covariance"][0].__setitem__(1, 9.0), "covariance: must be symmetric with variances >= 0"),
    (lambda c: c.update(axes="forward-left-up"), "axes: differ from vehicle.axes"),
    (lambda c: c.update(axes="sideways"), "axes: got 'sideways'; expected forward-left-up, forward-right-down"),
    (lambda c: c["integration"].update(step=0.0), "integration.step: got '0.0', expected a number above 0"),
    (lambda c: c["noise"].update(correlated={"position": 0.1, "heading": 0.1, "memory": 0.0}), "noise.correlated.memory: got '0.0', expected a number above 0"),
    (lambda c: c["noise"].update(correlated={"position": 0.1, "heading": 0.1, "memory": 1.0, "period": 0.0}), "noise.correlated.period: got '0.0', expected a number above 0"),
    (lambda c: c["envelope"]["speeds"].update(u=[1.0]), "envelope.speeds.u: expected two numbers"),
    (lambda c: c["vehicle"]["chain"][0].update(actuators=["sail"]), "got 'sail'; the actuators are port_surge"),
    (lambda c: c["vehicle"]["chain"][0]["scale"].update(signal="wind"), "got 'wind'; scales has propeller_speed"),
    (lambda c: c["vehicle"]["chain"][0].update(power=2.0), "a pair stands instead of"),
    (lambda c: c["vehicle"]["chain"][0].update(table=[[0, 0], [1, 0.5]]), "must give thrust 1 at command 1"),
    (lambda c: c["vehicle"]["forces"].update(F_u={"axis": "heave", "of": {}}), "vehicle.forces.F_u.axis: got 'heave'"),
    (lambda c: c["vehicle"].update(allocation={"scheme": "always-forward"}), "needs thrusters"),
]  # fmt: skip


def refused(program, path):
    """The one line that a program says of a file."""
    said = program.complaint(path)
    assert said.startswith(f"{path}: ")
    assert said.count("\n") == 1
    return said


@pytest.mark.parametrize(("change", "words"), BAD)
def test_a_file_that_is_not_right_is_one_line_in_both_languages(
    program, content, tmp_path, change, words
):
    path = tmp_path / "bad.yaml"
    change(content)
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    assert words in refused(program, path)
    with pytest.raises(SeatrialError):
        load(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "expected 'key: value' lines"),
        (b"- a\n- b\n", "expected 'key: value' lines"),
        (b"seatrial: model 3\n  name: [1,\n", "is not YAML"),
        (b"seatrial: model 3\nname: \"a\n", "cut off"),
        (b"\x00\x01\x02", "is not text"),
        (b"seatrial: model 3\nseatrial: model 3\n", "key 'seatrial' stands twice"),
    ],
)  # fmt: skip
def test_what_is_no_model_file_is_one_line(program, tmp_path, text, words):
    path = tmp_path / "bad.yaml"
    path.write_bytes(text)
    assert words in refused(program, path)
    with pytest.raises(SeatrialError):
        load(path)


def test_a_file_that_was_cut_off_anywhere_is_one_line(program, ship, tmp_path):
    path = tmp_path / "cut.yaml"
    for end in np.linspace(0, ship.index("\nvehicle:"), 25).astype(int):
        path.write_text(ship[:end])
        refused(program, path)


def test_no_file_and_a_folder_are_one_line(program, tmp_path):
    for path in (tmp_path / "none.yaml", tmp_path):
        assert program.complaint(path) == f"{path}: no such file, or it can't be read\n"
