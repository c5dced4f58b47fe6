# SPDX-License-Identifier: MIT
"""Tables of pages: written between marks, some rows on the page and all in a file beside it."""

import csv
import re

import pytest
from test_docs import ROOT

from benchmarks.harness.page import MARK, RULE, cells, csv_of, fill, refill
from seatrial.util.errors import FileError

TABLE = "| boat | error |\n| --- | ---: |\n| still MP | 1 |\n| still AF | 2 |\n| pushed MP | 3 |"
PAGES = sorted((ROOT / "docs").glob("*.md"))


def rows_of(path):
    return [row for row in csv.reader(path.read_text().splitlines()) if row]


def test_a_block_shows_the_rows_with_its_words_and_the_file_has_all(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "a\n\n<!-- some: still MP; pushed -->\nold\n<!-- end -->\n\n<!-- all -->\nx\n<!-- end -->\n"
    )
    refill(page, {"some": TABLE})
    shown = page.read_text()
    assert "| still MP | 1 |\n| pushed MP | 3 |\n\n<!-- end -->" in shown
    assert "| boat | error |\n|---|---:|\n| still MP | 1 |" in shown
    assert "still AF" not in shown
    assert "<!-- all -->\nx\n<!-- end -->" in shown
    assert rows_of(csv_of(page, "some")) == [
        ["boat", "error"], ["still MP", "1"], ["still AF", "2"], ["pushed MP", "3"],
    ]  # fmt: skip
    refill(page, {"some": TABLE})
    assert page.read_text() == shown


def test_a_table_without_such_a_row_is_left_out_and_its_heading_is_in_the_file(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("<!-- some: still -->\n<!-- end -->\n")
    refill(page, {"some": f"{TABLE}\n\n### more\n\n| other |\n| --- |\n| 4 |"})
    assert "other" not in page.read_text()
    assert rows_of(csv_of(page, "some"))[-3:] == [["more"], ["other"], ["4"]]


def test_a_table_that_is_only_linked_to_is_in_its_file(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("[all](tables/page-some.csv), [of another page](tables/other-rest.csv)\n")
    refill(page, {"some": TABLE, "rest": TABLE})
    assert page.read_text().startswith("[all]")
    assert len(rows_of(csv_of(page, "some"))) == 4
    assert [path.name for path in (tmp_path / "tables").iterdir()] == ["page-some.csv"]
    fill(page, {"some": lambda: TABLE})
    with pytest.raises(FileError, match="no table some; there are rest"):
        fill(page, {"rest": lambda: TABLE})


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_what_a_page_shows_of_a_table_is_in_its_file_and_the_page_links_to_it(page):
    text = page.read_text()
    for mark in MARK.finditer(text):
        if mark["words"]:
            path = csv_of(page, mark["name"])
            assert f"](tables/{path.name})" in text
            shown = [cells(line) for line in mark[0].splitlines() if re.match(r"\|", line)]
            shown = [row for row in shown if not RULE.fullmatch(f"| {' | '.join(row)} |")]
            every = rows_of(path)
            assert len(shown) < len(every)
            assert all(row in every for row in shown)
