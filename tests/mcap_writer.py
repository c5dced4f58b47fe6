# SPDX-License-Identifier: MIT
"""A small writer of .mcap, made from its specification, in every shape that recorders leave behind."""

import io
import struct
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import bag_tools
import lz4.frame
from backports import zstd
from bag_tools import Sent, by_time, store


def mcap(
    path: Path, sent: Sequence[Sent], compression: str = "zstd", *, chunk: int = 100,
    crc: bool = True, summary: bool = True, order: Callable[[list[Sent]], list[Sent]] = by_time,
    idl: dict[str, str] | None = None,
) -> Path:  # fmt: skip
    """An .mcap from the specification (https://mcap.dev/spec). chunk 0: no chunks."""
    out = io.BytesIO(b"\x89MCAP0\r\n")
    out.seek(0, 2)
    _put(out, 0x01, _text("ros2") + _text("tests"))
    schemas: dict[str, tuple[int, bytes]] = {}
    channels: dict[str, tuple[int, bytes]] = {}
    counts: dict[int, int] = {}
    infos: list[bytes] = []
    block, index, times = io.BytesIO(), {}, []

    def close() -> None:
        nonlocal block, index, times
        content = block.getvalue()
        packed = {
            "": bytes, "lz4": lz4.frame.compress, "zstd": zstd.compress,
        }[compression](content)  # fmt: skip
        at = out.tell()
        first, last = (min(times), max(times)) if times else (0, 0)
        _put(
            out, 0x06,
            struct.pack("<QQQI", first, last, len(content), zlib.crc32(content) if crc else 0)
            + _text(compression) + struct.pack("<Q", len(packed)) + packed,
        )  # fmt: skip
        end = out.tell()
        offsets = b""
        for channel, entries in index.items():
            offsets += struct.pack("<HQ", channel, out.tell())
            body = b"".join(struct.pack("<QQ", *entry) for entry in entries)
            _put(out, 0x07, struct.pack("<HI", channel, len(body)) + body)
        infos.append(
            struct.pack("<QQQQI", first, last, at, end - at, len(offsets)) + offsets
            + struct.pack("<Q", out.tell() - end) + _text(compression)
            + struct.pack("<QQ", len(packed), len(content))
        )  # fmt: skip
        block, index, times = io.BytesIO(), {}, []

    for i, s in enumerate(order(list(sent))):
        target = block if chunk else out
        if s.type not in schemas:
            text = (idl or {}).get(s.type)
            encoding = "ros2msg" if text is None else "ros2idl"
            text = text or store(ros1=False).generate_msgdef(s.type, ros_version=2)[0]
            schemas[s.type] = (
                len(schemas) + 1,
                struct.pack("<H", len(schemas) + 1) + _text(s.type) + _text(encoding) + _text(text),
            )
            _put(target, 0x03, schemas[s.type][1])
        if s.topic not in channels:
            number = len(channels)
            channels[s.topic] = (
                number,
                struct.pack("<HH", number, schemas[s.type][0]) + _text(s.topic) + _text("cdr")
                + struct.pack("<I", 0),
            )  # fmt: skip
            _put(target, 0x04, channels[s.topic][1])
        channel = channels[s.topic][0]
        index.setdefault(channel, []).append((s.time, target.tell()))
        times.append(s.time)
        counts[channel] = counts.get(channel, 0) + 1
        _put(
            target,
            0x05,
            struct.pack("<HIQQ", channel, i, s.time, s.time) + bag_tools.raw(s, ros1=False),
        )
        if chunk and i % chunk == chunk - 1:
            close()
    if chunk and times:
        close()
    _put(out, 0x0F, struct.pack("<I", 0))
    begin = out.tell()
    if summary:
        for _, body in schemas.values():
            _put(out, 0x03, body)
        for _, body in channels.values():
            _put(out, 0x04, body)
        table = b"".join(struct.pack("<HQ", *pair) for pair in counts.items())
        stamps = [s.time for s in sent] or [0]
        _put(
            out, 0x0B,
            struct.pack(
                "<QHIIIIQQI", len(sent), len(schemas), len(channels), 0, 0, len(infos),
                min(stamps), max(stamps), len(table),
            ) + table,
        )  # fmt: skip
        for body in infos:
            _put(out, 0x08, body)
    _put(out, 0x02, struct.pack("<QQI", begin if summary else 0, 0, 0))
    out.write(b"\x89MCAP0\r\n")
    path.write_bytes(out.getvalue())
    return path


def _put(out: io.BytesIO, kind: int, body: bytes) -> None:
    out.write(struct.pack("<BQ", kind, len(body)) + body)


def _text(text: str) -> bytes:
    return struct.pack("<I", len(text.encode())) + text.encode()
