# SPDX-License-Identifier: MIT
"""One boat twice: with plain names, and with names that a model file may have to break a program with."""

import random
from dataclasses import replace

from conftest import make_model

import seatrial
from seatrial.boat.schema import EstimatorEntry
from seatrial.boat.vehicle import vehicle_from

PROOF = "PROOF_OF_CODE_THAT_RAN"
CREATES = f'int creat(const char*,unsigned);__attribute__((constructor)) static void p(void){{creat("{PROOF}",384);}}'
PIECES = (
    f"*/ {CREATES} /*", f"*/\n{CREATES}\n/*", f'");system("touch {PROOF}");("', f"\nsystem('touch {PROOF}');\n%",
    f"');system('touch {PROOF}');('", "\n%{\n", "\n%}\n", "*/", "/*", "//", "??/", "\\\n", "\\", '"', "'", "`", "%", "%%", "%s%n",
    "#", "{", "}", "${name}", "$NAME", "]]>", "-->", "--", "<b>", "&amp;", "\x00", "\x1b[2J", "\x7f", "\u202e", "\u2028", "\ufeff",
    "\r", "\t", "\n---\n", ": ", "- ", "é", "ø", "日本", "Ⅷ", "²", " ", ".", "-", "_", "__", "1", "int", "double", "end", "F", "p", "u",
    "A", "nu", "inf", "linux", "base_link", "bow-thruster", "bow_thruster", "x" * 80, "\\input{/etc/passwd}", "\\end{align*}",
)  # fmt: skip
WORDS = ("a", "b", "c")
TERMS = {
    "surge": ["v * r", "X_u * u", "X_F * {0}"],
    "sway": ["-1 * u * r", "Y_v * v", "Y_F * {1}"],
    "yaw": ["N_ud * u_dot", "N_r * r", "N_F * {2}"],
}
VALUES = {"X_u": -0.4, "X_F": 0.5, "Y_v": -0.6, "Y_F": 0.3, "N_ud": 0.05, "N_r": -0.8, "N_F": 1.2}


def boat(title, inputs, forces, groups, scale, *, method="given") -> seatrial.Model:
    """Three actuators, each with its own group of stages; a known signal scales the last."""
    chain = [
        {"name": group, "actuators": [name], "latency": 0.05 * k, "lag": 0.1 + 0.1 * k, "power": 1.5,
         "dead_zone": {"forward": 0.05, "reverse": 0.1}}
        for k, (group, name) in enumerate(zip(groups, inputs, strict=True))
    ]  # fmt: skip
    chain[2]["scale"] = {"signal": scale, "power": 2.0}
    chain.append({"gains": dict(zip(inputs, (0.9, 1.0, 1.1), strict=True))})
    content = {
        "seatrial": "vehicle 1", "name": title, "axes": "forward-left-up", "pose": {},
        "commands": {"inputs": {name: {"column": f"c{k}"} for k, name in enumerate(inputs)}},
        "scales": {scale: {"column": "s", "reference": 3.0}},
        "forces": {
            force: {"axis": axis, "of": {name: 1.0}}
            for force, axis, name in zip(forces, TERMS, inputs, strict=True)
        },
        "structure": {axis: [line.format(*forces) for line in lines] for axis, lines in TERMS.items()},
        "chain": chain,
    }  # fmt: skip
    model = make_model(vehicle_from(content, "names"), VALUES, step=0.05)
    return replace(model, estimator=EstimatorEntry(method))


def plain_boat() -> seatrial.Model:
    return boat("boat", WORDS, ("F_u", "F_v", "F_r"), ("one", "two", "three"), "speed")


def hostile_boat(seed: int, monkeypatch) -> seatrial.Model:
    """The same with hostile names; the grammar of files is off, so that the exports stand alone."""
    rng = random.Random(seed)

    def name(begin: str = "", *, between: str | None = None) -> str:
        word = begin + "".join(rng.choice(PIECES) for _ in range(rng.randint(1, 3)))
        return (
            word
            if between is None
            else "".join(c for c in word if c not in " *·" and not c.isspace())
        )

    def three(begin: str = "", *, between: str | None = None) -> list[str]:
        found: dict[str, None] = {}
        while len(found) < 3:
            found[name(begin, between=between)] = None
        return [*found]

    monkeypatch.setattr("seatrial.boat.vehicle.check_vehicle_names", lambda _file, _source: None)
    return boat(name(), three(), three("F_", between=""), three(), name(), method=name())
