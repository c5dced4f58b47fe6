# SPDX-License-Identifier: MIT
"""A hook of MkDocs: pages that the program itself writes, in place of the short ones of the repository."""

from collections.abc import Callable, Mapping
from typing import Any

import json_page  # beside this file
import reference
import troubleshooting

PAGES: Mapping[str, Callable[[], str]] = {
    "reference.md": reference.page,
    "json.md": json_page.page,
    "troubleshooting.md": troubleshooting.page,
}


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:  # noqa: ANN401
    """Options and docstrings, fields of JSON, messages."""
    maker = PAGES.get(page.file.src_uri)
    return maker() if maker else markdown
