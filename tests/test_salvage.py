# SPDX-License-Identifier: MIT
"""Bags that are cut off or damaged give every message that is left."""

import re
import struct
from collections.abc import Iterator

import numpy as np
import pytest
from bad_bag_tools import LENGTH, both, made, messages, refused
from bag_shapes import WRITERS
from bag_tools import (
    Sent,
    bag_records,
    drive,
    joy_sent,
    mcap_records,
    poses_sent,
    raw,
    ros1,
    split1,
    split2,
    vehicle,
)
from mcap_writer import mcap

import seatrial
from seatrial.io.bags.opening import open_bag
from seatrial.io.bags.ros1_records import chunk_messages

PAGE = 4096  # [bytes] of a database


# Truncated, torn, overwritten: refused, and salvaged #


def bag_messages(content: bytes, start: int = 13) -> Iterator[int]:
    """Where each message of an uncompressed .bag ends."""
    for op, begin, end in bag_records(content):
        if op == 5:
            (head,) = struct.unpack_from("<I", content, begin)
            inner = begin + 8 + head
            for kind, _, stop in bag_records(b"\0" * start + content[inner:end]):
                if kind == 2:
                    yield inner + stop - start


CUTS = np.linspace(0.12, 0.995, 23)


def cut_off(path, share, words="--salvage"):
    """Messages of the whole bag, those found after a cut, which are its first, its content, and the byte of the cut."""
    whole, content = messages(path), path.read_bytes()
    cut = int(share * len(content))
    path.write_bytes(content[:cut])
    refused(path, words)
    found = messages(path, salvage=True)
    assert found == whole[: len(found)]
    return whole, found, content, cut


@pytest.mark.parametrize("share", CUTS)
def test_a_cut_off_bag_gives_every_message_before_the_cut(tmp_path, sent, share):
    path = ros1(tmp_path / "run.bag", sent)
    said = r"the bag is not whole .*: was the recording cut off\? --salvage reads what is left"
    _, found, content, cut = cut_off(path, share, said)
    assert len(found) == sum(end <= cut for end in bag_messages(content))


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
@pytest.mark.parametrize("share", CUTS[5::3])
def test_a_cut_off_compressed_bag_gives_every_whole_chunk(tmp_path, sent, compression, share):
    path = ros1(tmp_path / "run.bag", sent, compression, chunk=1 << 12)
    whole, found, content, cut = cut_off(path, share)
    chunks = [end for op, _, end in bag_records(content) if op == 5]
    with open_bag(path, salvage=True) as bag:
        assert "salvaged (" in bag.remarks[0]
    done = sum(end <= cut for end in chunks)
    assert len(found) >= done * 0.6 * len(whole) / len(chunks)
    if done == len(chunks):
        assert found == whole


def test_a_salvaged_recording_is_the_begin_of_the_whole_one(tmp_path, sent):
    path = ros1(tmp_path / "run.bag", sent)
    whole = seatrial.read(path, vehicle())
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    part = seatrial.read(path, vehicle(), salvage=True)
    n, m = len(part.stamps), len(part.commands.stamps)
    assert 20 < n < 45
    np.testing.assert_array_equal(part.eta, whole.eta[:n])
    np.testing.assert_array_equal(part.commands.values, whole.commands.values[:m])
    said = r"salvaged \(the bag is not whole \(.*\)\): \d+ messages, 1 damaged parts left out"
    assert re.fullmatch(said, part.remarks[0])


def unclosed(content: bytes) -> bytes:
    """A .bag as it is while it is recorded: no index, no counts."""
    head = content.index(b"index_pos=") + 10
    counts = content.index(b"conn_count=") + 11, content.index(b"chunk_count=") + 12
    (index,) = struct.unpack_from("<Q", content, head)
    out = bytearray(content[:index])
    struct.pack_into("<Q", out, head, 0)
    for at in counts:
        struct.pack_into("<I", out, at, 0)
    return bytes(out)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_bag_that_was_never_closed_is_all_there(tmp_path, sent, compression):
    path = ros1(tmp_path / "run.bag", sent, compression)
    whole = messages(path)
    active = tmp_path / "run.bag.active"
    active.write_bytes(unclosed(path.read_bytes()))
    refused(active, "the bag is not whole .it has no index.: was the recording cut off")
    assert messages(active, salvage=True) == whole
    assert seatrial.read(active, vehicle(), salvage=True).name == "run"


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_the_chunk_that_was_being_written_is_read_as_far_as_it_goes(tmp_path, sent, compression):
    """rosbag writes a chunk's lengths when the chunk is done; until then they are 0."""
    path = ros1(tmp_path / "run.bag", sent, compression)
    whole, content = messages(path), bytearray(unclosed(path.read_bytes()))
    _, begin, end = [r for r in bag_records(bytes(content)) if r[0] == 5][-1]
    (head,) = struct.unpack_from("<I", content, begin)
    struct.pack_into("<I", content, content.index(b"size=", begin) + 5, 0)
    struct.pack_into("<I", content, begin + 4 + head, 0)
    path.write_bytes(content[:end])  # killed before its indices were written
    assert messages(path, salvage=True) == whole
    path.write_bytes(content[: (begin + end) // 2])
    found = messages(path, salvage=True)
    assert found == whole[: len(found)]
    assert len(found) > (0.9 if compression == "none" else 0.7) * len(whole)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("what", ["data", "header", "all"])
def test_a_destroyed_chunk_loses_its_own_messages_only(tmp_path, sent, compression, what):
    path = ros1(tmp_path / "run.bag", sent, compression, chunk=1 << 12)
    whole, content = messages(path), bytearray(path.read_bytes())
    chunks = [(begin, end) for op, begin, end in bag_records(bytes(content)) if op == 5]
    begin, end = chunks[len(chunks) // 2]
    with open_bag(path) as bag:
        place = bag._chunks[len(chunks) // 2]
        lost = len(list(chunk_messages(bag._content(place))))
    (head,) = struct.unpack_from("<I", content, begin)
    first, last = {
        "data": (begin + 8 + head, end),
        "header": (begin, begin + 8 + head),
        "all": (begin, end),
    }[what]
    content[first:last] = np.random.default_rng(0).bytes(last - first)
    path.write_bytes(content)
    refused(path, "the bag is damaged at byte .*--salvage reads what is left")
    found = messages(path, salvage=True)
    assert len(found) == len(whole) - lost
    assert [m for m in whole if m in set(found)] == found
    record = seatrial.read(path, vehicle(), salvage=True)
    assert record.remarks[0].startswith("salvaged (the bag is damaged at byte")


@pytest.mark.parametrize("compression", ["", "zstd", "lz4"])
@pytest.mark.parametrize("share", CUTS[::2])
def test_a_cut_off_mcap_gives_every_message_before_the_cut(tmp_path, sent, compression, share):
    path = mcap(tmp_path / "run.mcap", sent, compression, chunk=50)
    whole, found, content, cut = cut_off(path, share)
    assert found == sorted(found, key=lambda m: m[1])
    ends = [end for kind, _, end in mcap_records(content) if kind == 6]
    least = 50 * sum(end <= cut for end in ends)
    assert len(found) >= min(least, len(whole))
    if compression == "" and least < len(whole):
        at = next(begin for kind, begin, end in mcap_records(content) if kind == 6 and end > cut)
        inner = content[at + 40 : cut]
        count, place = 0, 0
        while place + 9 <= len(inner):
            kind, length = struct.unpack_from("<BQ", inner, place)
            place += 9 + length
            count += kind == 5 and place <= len(inner)
        assert len(found) == least + count


@pytest.mark.parametrize("share", CUTS[::4])
def test_a_cut_off_mcap_without_chunks_gives_every_message_before_the_cut(tmp_path, sent, share):
    path = mcap(tmp_path / "run.mcap", sent, chunk=0)
    _, found, content, cut = cut_off(path, share)
    ends = [end for kind, _, end in mcap_records(content) if kind == 5]
    assert len(found) == sum(end <= cut for end in ends)


@pytest.mark.parametrize("compression", ["", "zstd", "lz4"])
@pytest.mark.parametrize("which", [0, 3, -1])
def test_an_mcap_with_a_bad_checksum_loses_that_chunk_only(tmp_path, sent, compression, which):
    """With the first chunk the definitions are lost; the summary has them again."""
    path = mcap(tmp_path / "run.mcap", sent, compression, chunk=50)
    whole, content = messages(path), bytearray(path.read_bytes())
    chunks = [begin for kind, begin, _ in mcap_records(bytes(content)) if kind == 6]
    content[chunks[which] + 24] ^= 0xFF  # of the checksum
    path.write_bytes(content)
    refused(path, r"the bag is damaged \(Chunk checksum mismatch.*--salvage reads what is left")
    found = messages(path, salvage=True)
    first = 50 * (which % len(chunks))
    assert found == whole[:first] + whole[first + 50 :]
    record = seatrial.read(path, vehicle(), salvage=True)
    assert record.remarks == (f"salvaged: {len(found)} messages, 1 damaged parts left out",)


@pytest.mark.parametrize("compression", ["", "zstd"])
def test_an_mcap_with_a_hole_is_read_on_both_sides_of_it(tmp_path, sent, compression):
    path = mcap(tmp_path / "run.mcap", sent, compression, chunk=50, crc=False)
    whole, content = messages(path), bytearray(path.read_bytes())
    chunks = [(begin, end) for kind, begin, end in mcap_records(bytes(content)) if kind == 6]
    begin, _ = chunks[2]
    _, end = chunks[3]
    content[begin - 9 : end] = bytes(end - begin + 9)  # two chunks, and the index between
    path.write_bytes(content)
    refused(path, "--salvage")
    assert messages(path, salvage=True) == whole[:100] + whole[200:]


def test_a_hole_in_an_mcap_without_chunks_costs_what_is_in_it(tmp_path, sent):
    path = mcap(tmp_path / "run.mcap", sent, chunk=0)
    whole, content = messages(path), bytearray(path.read_bytes())
    ends = [(begin - 9, end) for kind, begin, end in mcap_records(bytes(content)) if kind == 5]
    first, last = ends[100][0] + 3, ends[109][0] + 20
    content[first:last] = bytes(last - first)
    path.write_bytes(content)
    refused(path, "--salvage")
    assert messages(path, salvage=True) == whole[:100] + whole[110:]


def pages_of(content: bytes, sent: list[Sent]) -> list[int]:
    """The page of a database that each message is on."""
    return [content.index(raw(s, ros1=False)) // PAGE for s in sorted(sent, key=lambda s: s.time)]


@pytest.mark.parametrize("which", [[3], [4, 5, 9], [2, 8, 12], [-1]])
def test_a_database_with_zeroed_pages_gives_every_row_on_the_others(tmp_path, which):
    sent = poses_sent(9.0) + joy_sent(9.0)  # all different
    path = WRITERS["db3 file"](tmp_path, sent)
    whole, content = messages(path), bytearray(path.read_bytes())
    home = pages_of(bytes(content), sent)
    pages = sorted(set(home))
    bad = {pages[i] for i in which}
    for page in bad:
        content[page * PAGE : (page + 1) * PAGE] = bytes(PAGE)
    path.write_bytes(content)
    refused(path, r"the bag is damaged .*--salvage reads what is left")
    found = messages(path, salvage=True)
    assert found == [m for m, page in zip(whole, home, strict=True) if page not in bad]
    assert 0 < len(found) < len(whole)
    record = seatrial.read(path, vehicle(), salvage=True)
    assert "damaged parts left out" in record.remarks[0]


@pytest.mark.parametrize("share", [0.5, 0.8, 0.95])
def test_a_cut_off_database_gives_the_rows_that_are_there(tmp_path, share):
    sent = poses_sent(LENGTH) + joy_sent(LENGTH)
    path = WRITERS["db3 file"](tmp_path, sent)
    whole, content = messages(path), path.read_bytes()
    cut = int(share * len(content)) // PAGE * PAGE
    home = pages_of(content, sent)
    path.write_bytes(content[:cut])
    refused(path, "--salvage")
    found = messages(path, salvage=True)
    assert found == [m for m, page in zip(whole, home, strict=True) if page < cut // PAGE]


def test_a_database_without_its_list_of_topics_is_lost(tmp_path, sent):
    path = WRITERS["db3 file"](tmp_path, sent)
    content = bytearray(path.read_bytes())
    content[100:PAGE] = bytes(PAGE - 100)
    path.write_bytes(content)
    refused(path, "--salvage")
    refused(path, "its list of topics is lost .*; nothing to salvage", salvage=True)


def test_one_damaged_file_of_a_split_recording_costs_itself_only(tmp_path, sent):
    for folder in (split1(tmp_path / "one", sent), split2(tmp_path / "two", sent, "mcap")):
        file = next(p for p in folder.iterdir() if p.stem.endswith("_4"))
        whole = messages(folder)
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
        refused(folder, "--salvage")
        found = messages(folder, salvage=True)
        assert 0 < len(whole) - len(found) < len(whole) / 12
        assert [m for m in whole if m in set(found)] == found
        assert "salvaged" in seatrial.read(folder, vehicle(), salvage=True).remarks[0]


@pytest.mark.parametrize("kind", ["db3 message zstd", "mcap message zstd"])
def test_messages_compressed_one_by_one_are_salvaged_too(tmp_path, sent, kind):
    folder = WRITERS[kind](tmp_path, sent)
    whole = messages(folder)
    file = next(p for p in folder.iterdir() if p.suffix in (".mcap", ".db3"))
    content = bytearray(file.read_bytes())
    if file.suffix == ".mcap":
        content = content[: int(0.6 * len(content))]
    else:
        content[8 * PAGE : 9 * PAGE] = bytes(PAGE)
    file.write_bytes(content)
    refused(folder, "--salvage")
    found = messages(folder, salvage=True)
    assert 0.3 * len(whole) < len(found) < len(whole)
    assert set(found) < set(whole)


@pytest.mark.parametrize("kind", ["db3 file zstd", "mcap file zstd"])
def test_a_compressed_file_that_was_cut_off_is_unpacked_as_far_as_it_goes(tmp_path, kind):
    sent = drive(60.0)
    folder = WRITERS[kind](tmp_path, sent)
    whole = messages(folder)
    file = next(p for p in folder.iterdir() if p.suffix == ".zstd")
    file.write_bytes(file.read_bytes()[: int(0.7 * file.stat().st_size)])
    refused(folder, "damaged.*--salvage")
    (folder / "metadata.yaml").unlink()
    refused(folder, "the compressed bag is not whole; --salvage reads what is left")
    found = messages(folder, salvage=True)
    assert 0.3 * len(whole) < len(found) < len(whole)
    assert set(found) <= set(whole)


@both
def test_a_message_that_is_cut_short_is_refused_or_left_out(tmp_path, sent, kind, monkeypatch):
    import bag_tools

    good = bag_tools.raw
    short = joy_sent(LENGTH)[40]

    def cut(message: Sent, *, ros1: bool) -> bytes:
        whole = good(message, ros1=ros1)
        return whole[:-9] if message == short else whole

    monkeypatch.setattr(bag_tools, "raw", cut)
    path = made(tmp_path, kind, sent)
    refused(path, "a message on /joy ends before a length; --salvage reads what is left")
    record = seatrial.read(path, vehicle(), salvage=True)
    assert len(record.commands.stamps) == 299
    assert "1 unreadable messages on /joy" in record.remarks


def test_nothing_to_salvage_says_so(tmp_path, sent):
    path = ros1(tmp_path / "run.bag", sent)
    path.write_bytes(path.read_bytes()[:4200])
    refused(path, "no message could be salvaged", salvage=True)
    path = mcap(tmp_path / "run.mcap", sent)
    path.write_bytes(path.read_bytes()[:40])
    refused(path, "no message could be salvaged", salvage=True)
