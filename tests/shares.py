# SPDX-License-Identifier: MIT
"""Which tests each worker of a run begins with."""

import pytest

# files that take a minute or more, the longest first: each worker begins with its share of them
LONG = (
    "test_fuzz", "test_ros2_nodes", "test_demo", "test_notebooks", "test_hector", "test_many_boats",
    "test_wheels", "test_core_cpp", "test_ros2_node", "test_site", "test_docs", "test_ros1_node",
    "test_report_browser", "test_report_odd",
)  # fmt: skip


def shared_out(items: list[pytest.Item], workers: int) -> list[pytest.Item]:
    """The parts that xdist cuts the list into for its workers: in turn a long file, then as many others."""
    files: dict[str, list[pytest.Item]] = {name: [] for name in LONG}
    others = [item for item in items if item.path.stem not in files]
    for item in items:
        if item.path.stem in files:
            files[item.path.stem].append(item)
    present, ordered = [one for one in files.values() if one], []
    left = len(items)
    for place in range(workers):
        size = left // (workers - place)
        part = [item for one in present[place::workers] for item in one]
        fill = max(0, size - len(part))
        ordered += part + others[:fill]
        others, left = others[fill:], left - size
    return ordered + others
