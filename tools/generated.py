# SPDX-License-Identifier: MIT
"""A hook of MkDocs: pages that the program itself writes, in place of the short ones of the repository."""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:  # noqa: ANN401
    """Options and docstrings, fields of JSON, messages."""
    import json_page  # noqa: PLC0415 after the path
    import reference  # noqa: PLC0415
    import troubleshooting  # noqa: PLC0415

    made = {
        "reference.md": reference.page,
        "json.md": json_page.page,
        "troubleshooting.md": troubleshooting.page,
    }
    maker = made.get(page.file.src_uri)
    return maker() if maker else markdown
