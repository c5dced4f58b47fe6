# SPDX-License-Identifier: MIT
"""Numbers out of serialised messages are rosbags' own, for random messages of random types."""

import numpy as np
import pytest
from bag_tools import build, store
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from seatrial.io.bags.wire import Wire, parse_definition, plain
from seatrial.io.bags.wire_walk import MOST_ELEMENTS, PRIMITIVES, WireError, described
from seatrial.util.errors import RecordingError

ROOT = "test_msgs/msg/Root"
NUMBERS = ("bool", "byte", "char", *(p for p in PRIMITIVES if p[-1].isdigit()))
NAMES = st.sampled_from(["x", "mode", "thrust", "axes", "header", "label_2", "zZ"])


@st.composite
def definitions(draw) -> dict[str, str]:
    """Three message types, the later ones made of the earlier ones, too."""
    found: dict[str, str] = {}
    for name in ("test_msgs/msg/Leaf", "test_msgs/msg/Branch", ROOT):
        kinds = st.sampled_from([*NUMBERS, "string", *(n.replace("/msg", "") for n in found)])
        fields = draw(st.lists(NAMES, min_size=1, max_size=5, unique=True))
        ends = st.sampled_from(["", "", "[]", "[3]", "[<=4]"])
        found[name] = "\n".join(f"{draw(kinds)}{draw(ends)} {field}" for field in fields)
    return found


@st.composite
def values(draw, types, name, *, ros1: bool):
    """What `build` makes a message of."""
    return {field: draw(_value(types, kind, ros1=ros1)) for field, kind in types.fielddefs[name][1]}


def _value(types, kind, *, ros1: bool):  # noqa: PLR0911 one for each kind
    tag, detail = described(kind)
    if tag == "name":
        return values(types, detail, ros1=ros1)
    if tag == "many":
        element, size, is_sequence = detail
        least, most = (0, size or 4) if is_sequence else (size, size)
        return st.lists(_value(types, element, ros1=ros1), min_size=least, max_size=most)
    if detail == "string":
        return st.text(max_size=5).filter(lambda t: "\0" not in t)
    if detail == "bool":
        return st.booleans()
    if detail.startswith("float"):
        return st.floats(width=int(detail[5:]), allow_nan=True)
    if detail == "byte":  # rosbags gives it a sign in ROS 2, too, but not in arrays
        return st.integers(0, 127)
    code = np.dtype({"char": "u1", "octet": "u1"}.get(detail, detail))
    return st.integers(int(np.iinfo(code).min), int(np.iinfo(code).max))


def leaves(types, kind, value, path):
    """Every number and text of a message that rosbags made, by its path."""
    tag, detail = described(kind)
    if tag == "name":
        for field, inner in types.fielddefs[detail][1]:
            yield from leaves(types, inner, getattr(value, field), f"{path}.{field}".lstrip("."))
    elif tag == "many":
        for i, item in enumerate(value):
            yield from leaves(types, detail[0], item, f"{path}[{i}]")
    else:
        yield path, value


@settings(max_examples=80)
@given(definitions(), st.data())
def test_random_messages_of_random_types_are_read_as_rosbags_reads_them(texts, data):
    types = get_typestore(Stores.EMPTY)
    for name, text in texts.items():
        types.register(get_types_from_msg(text, name))
    format_ = data.draw(st.sampled_from(["ros1", "little", "big"]))
    ros1 = format_ == "ros1"
    raws, wanted = [], []
    for given_values in data.draw(st.lists(values(types, ROOT, ros1=ros1), min_size=1, max_size=4)):
        message = build(types, ROOT, given_values)
        raws.append(
            bytes(
                types.serialize_ros1(message, ROOT)
                if ros1
                else types.serialize_cdr(message, ROOT, little_endian=format_ == "little")
            )
        )
        read = types.deserialize_ros1 if ros1 else types.deserialize_cdr
        wanted.append(dict(leaves(types, (2, ROOT), read(raws[-1], ROOT), "")))
    # through the text that a bag would bring
    text = types.generate_msgdef(ROOT, ros_version=1 if ros1 else 2)[0]
    wire = Wire(ROOT, parse_definition(text, ROOT), cdr=not ros1)
    seen = []
    for shape in wire.shapes(raws):
        seen += shape.rows.tolist()
        for path, value in wanted[shape.rows[0]].items():
            if isinstance(value, str):
                found = shape.texts(path)
                assert [wanted[row][path] for row in shape.rows] == found
                assert shape.numbers(path) is None
                continue
            floats = shape.numbers(path)
            expected = [float(wanted[row][path]) for row in shape.rows]
            np.testing.assert_array_equal(floats, expected)
            if not isinstance(value, float | np.floating) and -(2**63) <= int(value) < 2**63:
                assert shape.integers(path)[0] == int(wanted[shape.rows[0]][path])
        count = sum(1 if leaf.dtype == "S" else leaf.count for leaf in shape.leaves.values())
        assert count == len(wanted[shape.rows[0]])  # nothing beside
    assert sorted(seen) == list(range(len(raws)))


@pytest.mark.parametrize(("cdr", "value"), [(False, -2.0), (True, 254.0)])
def test_a_byte_has_a_sign_in_ros_1_only(cdr, value):
    raw = (b"\0\1\0\0" if cdr else b"") + b"\xfe\xfe\xfe"
    wire = Wire(ROOT, parse_definition("byte a\nbyte[2] b", ROOT), cdr=cdr)
    (shape,) = wire.shapes([raw])
    assert shape.numbers("a") == shape.numbers("b[1]") == [value]


@given(st.binary(max_size=300))
def test_random_bytes_are_refused_or_read_and_nothing_else(raw):
    types = store(ros1=False)
    for name in ("sensor_msgs/msg/Joy", "boat_msgs/msg/Motors", "tf2_msgs/msg/TFMessage"):
        for cdr in (True, False):
            wire = Wire(name, types.fielddefs, cdr=cdr)
            try:
                (shape,) = wire.shapes([raw])
            except WireError as error:
                assert str(error).isprintable()
                assert not wire.readable([raw])
            else:
                assert shape.data.tobytes() == raw


def test_a_shape_is_told_from_another_of_the_same_length():
    types = store(ros1=False)
    name = "boat_msgs/msg/Motors"
    wire = Wire(name, types.fielddefs, cdr=True)
    given_values = [
        {"id": 1, "motors": [{"name": "a", "duty": 5}, {"name": "bbbbb", "duty": 6}]},
        {"id": 2, "motors": [{"name": "aaaaa", "duty": 7}, {"name": "b", "duty": 8}]},
    ]
    raws = [bytes(types.serialize_cdr(build(types, name, v), name)) for v in given_values]
    shapes = list(wire.shapes(raws * 3))
    assert len(shapes) == 2
    for shape in shapes:
        first = given_values[shape.rows[0] % 2]["motors"]
        assert shape.numbers("motors[0].duty").tolist() == [first[0]["duty"]] * 3
        assert shape.numbers("motors[1].duty").tolist() == [first[1]["duty"]] * 3
        assert shape.texts("motors[1].name") == [first[1]["name"]] * 3


def test_messages_of_both_byte_orders_on_one_topic_are_told_apart():
    types = store(ros1=False)
    name = "geometry_msgs/msg/Twist"
    raws = [
        bytes(types.serialize_cdr(build(types, name, {"linear": {"x": x}}), name, little_endian=e))
        for x, e in ((1.5, True), (2.5, False), (3.5, True))
    ]
    found = np.zeros(3)
    for shape in Wire(name, types.fielddefs, cdr=True).shapes(raws):
        found[shape.rows] = shape.numbers("linear.x")
    assert found.tolist() == [1.5, 2.5, 3.5]


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("axis[0]", r"sensor_msgs/Joy has no 'axis'; did you mean 'axes'\?"),
        ("thrust", "has no 'thrust'; numbers there: header.stamp.sec, .*, axes"),
        ("axes", r"'axes' is not a number; numbers there: axes\[\]"),
        ("axes[0][1]", r"has no 'axes\[0\]\[1\]'; numbers there: axes\[0\]"),
        ("axes[-1]", r"'axes\[-1\]' is not a field; write it like axes\[1\] or a\.b\.c"),
        ("axes[0].x", r"has no 'axes\[0\]\.x'"),
        ("header.frame_id", "'header.frame_id' is not a number; there are no numbers in it"),
        ("header.stamp", "not a number; numbers there: header.stamp.sec, header.stamp.nanosec"),
        ("", "'' is not a field"),
    ],
)
def test_a_path_that_leads_to_no_number_is_refused_with_those_that_do(path, words):
    wire = Wire("sensor_msgs/msg/Joy", store(ros1=False).fielddefs, cdr=True)
    with pytest.raises(RecordingError, match=words) as caught:
        wire.require(path, "run.bag: topic /joy")
    assert str(caught.value).startswith("run.bag: topic /joy: ")


@pytest.mark.parametrize(
    ("text", "raw", "words"),
    [
        ("uint8[-5] a\nuint8 b", bytes(40), "states -5 elements in 'a'"),
        ("test_msgs/Gone a", bytes(40), "uses test_msgs/msg/Gone, which is not defined"),
        ("test_msgs/Root a", bytes(40), "uses test_msgs/msg/Root, which is not defined"),  # itself
        ("wstring a", bytes(40), "not defined|not read"),
        ("float64[4000000000] a", bytes(40), "ends inside 'a'"),
        ("string[] a", (9**9).to_bytes(4, "little") + bytes(36), f"states {9**9} elements in 'a'"),
        ("uint8 a", bytes(40), "has 39 bytes more than its definition"),
    ],
)
def test_definitions_that_make_no_sense_end_in_words(text, raw, words):
    with pytest.raises(WireError, match=words):
        list(Wire(ROOT, parse_definition(text, ROOT), cdr=False).shapes([raw]))


def test_empty_messages_within_messages_do_not_go_on_for_ever():
    rule = "=" * 80
    text = (
        f"test_msgs/A[{MOST_ELEMENTS}] a\n{rule}\nMSG: test_msgs/A\ntest_msgs/B[{MOST_ELEMENTS}] b\n"
        f"{rule}\nMSG: test_msgs/B\ntest_msgs/C[{MOST_ELEMENTS}] c\n{rule}\nMSG: test_msgs/C\n# none\n"
    )
    with pytest.raises(WireError, match="more fields than bytes"):
        list(Wire(ROOT, parse_definition(text, ROOT), cdr=False).shapes([bytes(8)]))


@given(st.text(max_size=400))
def test_text_out_of_a_file_is_shown_as_one_short_line(text):
    shown = plain(text)
    assert shown.isprintable()
    assert len(shown) <= 84
    if text.isprintable() and len(text) <= 80:
        assert shown == " ".join(text.split())
