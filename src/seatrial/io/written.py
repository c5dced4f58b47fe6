# SPDX-License-Identifier: MIT
"""Whether a file is still as it was written: what was edited since is not written over."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from seatrial.util.files import dump_json, sha256, write_text

DIGESTS = "written.json"


def edited(folder: Path, notes: Path) -> list[Path]:
    """Files below `folder` that are not as they were when `notes` was told of them."""
    known = {folder / name: digest for name, digest in _known(notes).items()}
    return [p for p, digest in known.items() if p.is_file() and sha256(p) != digest]


@contextmanager
def noted(folder: Path, notes: Path, paths: Sequence[Path]) -> Iterator[None]:
    """Notes what the files `paths` below `folder` are after the body; nothing of them if it fails."""
    names = {p.relative_to(folder).as_posix(): p for p in paths}
    rest = {name: digest for name, digest in _known(notes).items() if name not in names}
    write_text(notes, dump_json(rest))  # if it ends here, they are not taken for edited
    yield
    write_text(notes, dump_json(rest | {name: sha256(p) for name, p in names.items()}))


def _known(notes: Path) -> dict[str, str]:
    try:
        content = json.loads(notes.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in content.items()} if isinstance(content, dict) else {}
