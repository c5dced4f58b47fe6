# SPDX-License-Identifier: MIT
"""Names and texts of a model in other languages: identifiers, and comments that end where they end.

A model file is not trusted: whatever it calls a thing, the program that an export makes does nothing but compute
the boat. Every export makes its identifiers with `identifiers` and its texts with the function of its language.
"""

import re
import unicodedata
from collections.abc import Collection, Iterable

from seatrial.util.errors import ExportError

LONGEST_IDENTIFIER = 63  # [characters] that MATLAB and C99 tell apart
LONGEST_TEXT = 300  # [characters] in a comment
_KEYWORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl
    concept const constexpr continue decltype default delete do double dynamic_cast else elseif
    end end_try_catch end_unwind_protect endfor endfunction endif endparfor endswitch endwhile
    enum explicit export extern false float for friend function global goto if inline int long
    mutable namespace new noexcept not not_eq nullptr operator or or_eq otherwise parfor
    persistent private protected public register reinterpret_cast requires restrict return short
    signed sizeof spmd static static_assert static_cast struct switch template this thread_local
    throw true try typedef typeid typename typeof union unsigned until unwind_protect
    unwind_protect_cleanup using virtual void volatile wchar_t while xor xor_eq errno linux main
    math unix
"""  # of C, C++, MATLAB and Octave, and macros of their headers
KEYWORDS = frozenset(_KEYWORDS.split())


def identifier(stem: str) -> str:
    """A file's name as a name in a program. Raises ExportError where no letter or digit is left."""
    name = _ascii(stem).strip("_")
    if not name:
        raise ExportError(f"'{stem}' can't be a name in a program; name the file after the boat")
    return name if name[0].isalpha() and name not in KEYWORDS else f"boat_{name}"


def identifiers(names: Iterable[str], reserved: Collection[str] = ()) -> dict[str, str]:
    """Each name as one of ASCII letters, digits and _, unique, and none of a language or `reserved`.

    `bow-thruster` is bow_thruster; the second of two that are alike is bow_thruster_2.
    """
    taken, found = {*KEYWORDS, *reserved}, {}
    for name in dict.fromkeys(names):
        plain = _ascii(name)
        plain = plain if plain[:1].isalpha() else f"n_{plain.lstrip('_')}"
        number, one = 1, plain[:LONGEST_IDENTIFIER]
        while one in taken:
            number += 1
            one = f"{plain[: LONGEST_IDENTIFIER - len(str(number)) - 1]}_{number}"
        taken.add(one)
        found[name] = one
    return found


def line(text: str) -> str:
    """A text on one line: printable characters, no two blanks together."""
    shown = "".join(c if c.isprintable() else " " for c in text[: 2 * LONGEST_TEXT])
    return " ".join(shown.split())[:LONGEST_TEXT]


def c_comment(text: str) -> str:
    """For a comment between /* and */ in C: nothing ends it, begins another, or is a trigraph."""
    return re.sub(r"(?<=[*/])(?=[*/])", " ", line(text)).replace("??", "? ?")


def matlab_comment(text: str) -> str:
    """For a comment after % in MATLAB and Octave."""
    return line(text)


def matlab_text(text: str) -> str:
    """For a string between single quotes that is a format: quotes, % and escapes are doubled."""
    return re.sub(r"(['%\\])", r"\1\1", line(text))


def xml_comment(text: str) -> str:
    """For a comment in XML, which must not have two hyphens together nor end with one."""
    return re.sub(r"-(?=-)", "- ", line(text)).rstrip("-")


def _ascii(name: str) -> str:
    """ASCII letters, digits and _; letters without their accents."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    return re.sub(r"\W", "_", plain, flags=re.ASCII)
