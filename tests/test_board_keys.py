# SPDX-License-Identifier: MIT
"""The keys that the nodes' readers of files allow are the fields of Python's structs."""

import re
from collections.abc import Iterator
from typing import get_args, get_type_hints

import msgspec
from conftest import ROOT

from seatrial.boat import schema
from seatrial.boat.findings import Finding
from seatrial.control.gains_file import AxisMargins, GainsFile
from seatrial.simulation.scene import SceneFile

FILES = (schema.ModelFile, schema.VehicleFile, GainsFile, SceneFile)
# what a node has no use for: it does not look into it
LEFT_OUT = {schema.EstimatorEntry, schema.StepEntry, Finding, schema.RecordingEntry, schema.SourceEntry, AxisMargins}  # fmt: skip
OF_THE_MODEL = {schema.VehicleFile: {"structure"}}  # beside its vehicle


def structs(kind: object) -> Iterator[type[msgspec.Struct]]:
    """All that a type is made of."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        yield kind
        for hint in get_type_hints(kind).values():
            yield from structs(hint)
    for part in get_args(kind):
        yield from structs(part)


def test_a_node_knows_every_key_of_the_files_that_it_reads():
    """A list of keys `only({...})` for each struct, and no other."""
    source = "".join(p.read_text() for p in sorted((ROOT / "ros" / "common").glob("**/*.[hc]pp")))
    lists = re.findall(r"\b(?:\.|->)only\((.*?)\);", source, re.DOTALL)
    allowed = {frozenset(re.findall(r'"(\w+)"', keys)) for keys in lists if keys != "kAxisNames"}
    read = {struct for file in FILES for struct in structs(file)} - LEFT_OUT
    fields = {frozenset(s.__struct_encode_fields__) - OF_THE_MODEL.get(s, set()) for s in read}
    assert sorted(map(sorted, allowed ^ fields)) == []
