# SPDX-License-Identifier: MIT
"""The C++ tests of the core and of the nodes' messages, under the address and undefined-behaviour sanitizers."""

import pytest
from cpp_tools import built, run

pytestmark = pytest.mark.system


@pytest.mark.parametrize("tests", ["core_tests", "message_tests"])
def test_the_tests_in_cpp_pass_under_the_sanitizers(tests):
    shown = run(str(built(tests)))
    assert "Status: SUCCESS!" in shown
    assert "0 failed" in shown
