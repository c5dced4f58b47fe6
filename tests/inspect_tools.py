# SPDX-License-Identifier: MIT
"""What tests of `seatrial inspect` share: parts of its JSON and of its text."""

GOOD = "good for identification"


def stream(recording, source):
    (found,) = [s for s in recording["streams"] if s["source"] == source]
    return found


def fault(recording, word):
    (found,) = [f for f in recording["faults"] if word in f["kind"]]
    return found


def said(text):
    """The verdicts."""
    return [line.strip()[3:] for line in text.splitlines() if line.startswith("  => ")]
