# SPDX-License-Identifier: MIT
"""Tables of an HTML text, for the report's tests."""

from html.parser import HTMLParser


class Tables(HTMLParser):
    """Tables by class: rows of cells, each (text, values of its data elements)."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: dict[str, list[list[list[tuple[str, list[float]]]]]] = {}
        self.table, self.cell = None, None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        if tag == "table":
            self.table = []
            self.found.setdefault(named["class"].split()[-1], []).append(self.table)
        elif self.table is None:
            return
        elif tag == "tr":
            self.table.append([])
        elif tag in ("td", "th"):
            self.cell = ("", [])
        elif tag == "data":
            self.cell = (self.cell[0], [*self.cell[1], float(named["value"])])

    def handle_data(self, data):
        if self.cell is not None:
            self.cell = (self.cell[0] + data, self.cell[1])

    def handle_endtag(self, tag):
        if tag in ("td", "th") and self.cell is not None:
            self.table[-1].append(self.cell)
            self.cell = None
        elif tag == "table":
            self.table = None
