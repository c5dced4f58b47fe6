# SPDX-License-Identifier: MIT
"""Mutations of good files: bytes of bags, words of text, rows of databases."""

import contextlib
import random
import sqlite3
import struct

ODD_NUMBERS = (
    0, 1, 2, 3, 4, 7, 8, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000,
    0xFFFFFFFF, 1 << 32, 1 << 40, (1 << 63) - 1, 1 << 63, (1 << 64) - 1,
)  # fmt: skip
ODD_WORDS = (
    "", "nan", "inf", "-inf", "1e400", "-1e308", "1e308", "abc", "1,5", "--", "0x10", "9" * 400, "é",
    '"', "1_000", "-0", "1e-400", " ", "\x00", "NULL", "#", "9007199254740993", "-9e18", "9.3e18",
)  # fmt: skip
ODD_YAML = (
    "", "null", "~", "[]", "{}", "[1, 2]", "{a: 1}", "-1", "0", "1e308", "-1e308", "1e-320", ".nan",
    ".inf", "true", "'", '"', "*a", "&a 1", "!!python/object:os.system x", "\t", "|", ">", "? x", "-",
    "x" * 5000, "é\u2028", "9" * 400, "0x10", "1_0", "2020-01-01", "<<: *a", "axes[99]", "axes[-1]",
    "axes[1][2]", "header.frame_id", "header", "buttons[0]", "a.b.c", "axes[999999999999999999999]",
    "mm", "deg", "forward-right-down", "always-forward", "direct", "/tf", "/rosout", "F_u", "!", "%",
    "{field: axes, index: 1}", "{field: 'axes[0]', scale: 1e-300}", "{column: t, unit: ns}",
    "{field: 'axes[0]', offset: 1e308, scale: 1e-5}", "{column: t, scale: 1e-300}",
)  # fmt: skip


# Mutations of bytes #


def flip(rng: random.Random, data: bytearray) -> None:
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def scribble(rng: random.Random, data: bytearray) -> None:
    at = rng.randrange(len(data))
    size = rng.choice((1, 2, 4, 16, 256))
    data[at : at + size] = rng.randbytes(size)


def truncate(rng: random.Random, data: bytearray) -> None:
    del data[rng.randrange(len(data)) :]


def remove(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    del data[at : at + size]


def duplicate(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    data[at:at] = data[at : at + size]


def move(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    block = data[at : at + size]
    del data[at : at + size]
    to = rng.randrange(len(data) + 1)
    data[to:to] = block


def blank(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    size = min(size, len(data) - at)
    data[at : at + size] = bytes([rng.choice((0, 0, 0xFF))]) * size


def number(rng: random.Random, data: bytearray) -> None:
    """A length, a count or an offset that is not true."""
    form = rng.choice(("<H", "<I", "<I", "<Q", ">I"))
    size = struct.calcsize(form)
    if len(data) <= size:
        return
    at = rng.randrange(len(data) - size)
    value = rng.choice(ODD_NUMBERS)
    if rng.random() < 0.4:
        (value,) = struct.unpack_from(form, data, at)
        value += rng.choice((-8, -4, -1, 1, 4, 8, 256))
    struct.pack_into(form, data, at, value % (1 << 8 * size))


def _block(rng: random.Random, data: bytearray) -> tuple[int, int]:
    """Where a block begins, and its size; often a page of a database."""
    if rng.random() < 0.3:
        return rng.randrange(len(data)) // 4096 * 4096, 4096 * rng.choice((1, 1, 2, 4))
    return rng.randrange(len(data)), rng.choice((1, 3, 8, 50, 400, 3000, len(data) // 3 + 1))


BYTES = (flip, flip, scribble, truncate, remove, duplicate, move, blank, number, number, number)


def damaged(rng: random.Random, content: bytes, others: list[bytes]) -> bytes:
    """One or more mutations, or two files glued together."""
    data = bytearray(content)
    if rng.random() < 0.05:
        other = rng.choice(others)
        data = data[: rng.randrange(len(data))] + other[rng.randrange(len(other)) :]
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        if data:
            rng.choice(BYTES)(rng, data)
    return bytes(data)


# Mutations of text #


def edited(rng: random.Random, content: bytes, words: tuple[str, ...], separators: str) -> bytes:
    """Lines and words changed as a tired person or a broken script would."""
    lines = content.decode().split("\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(lines))
        how = rng.randrange(9)
        if how == 0:
            del lines[at]
        elif how == 1:
            lines.insert(at, rng.choice(lines or [""]))
        elif how == 2:
            lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
        elif how == 3:
            lines[at] = " " * rng.randrange(4) + lines[at] + rng.choice(words)
        elif how == 4:
            cut = rng.randrange(len(lines[at]) + 1)
            lines[at] = (
                lines[at][:cut] + rng.choice(",;:\t\"'[]{}#&*!|>%@` \x00é-") + lines[at][cut:]
            )
        else:
            lines[at] = _swapped(rng, lines[at], words, separators)
        lines = lines or [""]
    return "\n".join(lines).encode()


def _swapped(rng: random.Random, line: str, words: tuple[str, ...], separators: str) -> str:
    """One word of a line replaced."""
    starts = [0, *(i + 1 for i, c in enumerate(line) if c in separators)]
    begin = rng.choice(starts)
    end = next((i for i in range(begin, len(line)) if line[i] in separators), len(line))
    return line[:begin] + rng.choice(words) + line[end:]


def bomb(rng: random.Random) -> bytes:
    """YAML that grows, or goes deep."""
    depth = rng.choice((50, 1000, 20000))
    head = rng.choice(("", "seatrial: vehicle 1\n"))
    return rng.choice(
        (
            f"{head}a: &a [x,x,x,x,x,x,x,x,x]\n"
            + "".join(f"{chr(98 + i)}: &{chr(98 + i)} [{','.join([f'*{chr(97 + i)}'] * 9)}]\n" for i in range(9)),
            "seatrial: vehicle 1\nname: &a [*a]\n",
            "seatrial: vehicle 1\nname: &a {b: *a}\n",
            "seatrial: vehicle 1\nname: " + "[" * depth + "]" * depth,
            "seatrial: vehicle 1\nname: " + "{a: " * depth + "}" * depth,
            "seatrial: " + "x" * 1_000_000,
            "- " * depth,
        )
    ).encode()  # fmt: skip


def queried(rng: random.Random, content: bytes) -> bytes:
    """A database that is whole, with rows that no recorder writes."""
    values = ("NULL", "'text'", "x'00'", "1.5", "-1", "9223372036854775807", "-9223372036854775808",
              "''", "zeroblob(5)", "zeroblob(100000)", "x'00010000ffffffff'", "'/joy'", "17")  # fmt: skip
    columns = {
        "messages": ("id", "topic_id", "timestamp", "data"),
        "topics": ("id", "name", "type", "serialization_format", "offered_qos_profiles"),
        "message_definitions": ("topic_type", "encoding", "encoded_message_definition"),
        "schema": ("schema_version",),
    }
    base = sqlite3.connect(":memory:")
    base.deserialize(content)
    for _ in range(rng.choice((1, 1, 3))):
        table = rng.choice(list(columns))
        value, column = rng.choice(values), rng.choice(columns[table])
        which = rng.choice(("1", "rowid = 1", "rowid % 7 = 3", f"rowid > {rng.randrange(400)}"))
        relaxed = column == "id" or rng.random() < 0.5
        if relaxed:  # a table without its constraints, as another program might make it
            names = ", ".join(columns[table])
            statements = [
                f"CREATE TABLE t AS SELECT {names} FROM {table}", f"DROP TABLE {table}",
                f"ALTER TABLE t RENAME TO {table}",
            ]  # fmt: skip
        else:
            statements = []
        statements.append(
            rng.choice(
                (
                    f"UPDATE {table} SET {column} = {value} WHERE {which}",
                    f"UPDATE {table} SET {column} = {value} WHERE {which}",
                    f"DELETE FROM {table} WHERE {which}",
                    f"DROP TABLE {table}",
                    f"ALTER TABLE {table} DROP COLUMN {column}",
                    f"INSERT INTO {table} SELECT * FROM {table} WHERE {which}",
                )
            )
        )
        with contextlib.suppress(sqlite3.Error):
            for statement in statements:
                base.execute(statement)
        with contextlib.suppress(sqlite3.Error):
            base.commit()
    return bytes(base.serialize())
