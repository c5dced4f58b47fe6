# SPDX-License-Identifier: MIT
"""Every shape of a bag, each by its name."""

from collections.abc import Callable, Sequence
from pathlib import Path

from bag_tools import Sent, alone, old_db3, ros1, ros2, split1, split2
from mcap_writer import mcap

Writer = Callable[[Path, Sequence[Sent]], Path]
WRITERS: dict[str, Writer] = {
    "bag": lambda f, s: ros1(f / "run.bag", s),
    "bag, one chunk": lambda f, s: ros1(f / "run.bag", s, chunk=1 << 24),
    "bag bz2": lambda f, s: ros1(f / "run.bag", s, "bz2"),
    "bag lz4": lambda f, s: ros1(f / "run.bag", s, "lz4"),
    "bag.active": lambda f, s: ros1(f / "run.bag", s).rename(f / "run.bag.active"),
    "bag split": lambda f, s: split1(f / "run", s),
    "db3 folder": lambda f, s: ros2(f / "run", s, "sqlite3"),
    "db3 folder, metadata 8": lambda f, s: ros2(f / "run", s, "sqlite3", version=8),
    "db3 in its folder": lambda f, s: ros2(f / "run", s, "sqlite3") / "run.db3",
    "db3 file": lambda f, s: alone(ros2(f / "run", s, "sqlite3")),
    "db3 message zstd": lambda f, s: ros2(f / "run", s, "sqlite3", "MESSAGE"),
    "db3 message zstd, in its folder": lambda f, s: (
        ros2(f / "run", s, "sqlite3", "MESSAGE") / "run.db3"
    ),
    "db3 file zstd": lambda f, s: ros2(f / "run", s, "sqlite3", "FILE"),
    "db3 file zstd, the file": lambda f, s: ros2(f / "run", s, "sqlite3", "FILE") / "run.db3.zstd",
    "db3 split": lambda f, s: split2(f / "run", s, "sqlite3"),
    "db3 split, no metadata": lambda f, s: split2(f / "run", s, "sqlite3", metadata=False),
    "db3 before Iron": lambda f, s: old_db3(f, s, qos=True),
    "db3 before Foxy": lambda f, s: old_db3(f, s, qos=False),
    "mcap folder": lambda f, s: ros2(f / "run", s),
    "mcap folder, metadata 8": lambda f, s: ros2(f / "run", s, version=8),
    "mcap file": lambda f, s: alone(ros2(f / "run", s)),
    "mcap storage zstd": lambda f, s: ros2(f / "run", s, mode="STORAGE"),
    "mcap message zstd": lambda f, s: ros2(f / "run", s, mode="MESSAGE"),
    "mcap file zstd": lambda f, s: ros2(f / "run", s, mode="FILE"),
    "mcap split": lambda f, s: split2(f / "run", s, "mcap"),
    "mcap split, no metadata": lambda f, s: split2(f / "run", s, "mcap", metadata=False),
    "mcap, zstd and checksums": lambda f, s: mcap(f / "run.mcap", s),
    "mcap, lz4 and checksums": lambda f, s: mcap(f / "run.mcap", s, "lz4"),
    "mcap, plain and checksums": lambda f, s: mcap(f / "run.mcap", s, ""),
    "mcap, no checksums": lambda f, s: mcap(f / "run.mcap", s, crc=False),
    "mcap, no index": lambda f, s: mcap(f / "run.mcap", s, summary=False),
    "mcap, no chunks": lambda f, s: mcap(f / "run.mcap", s, chunk=0),
    "mcap, no chunks, no index": lambda f, s: mcap(f / "run.mcap", s, chunk=0, summary=False),
}
