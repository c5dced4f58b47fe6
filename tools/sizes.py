# SPDX-License-Identifier: MIT
"""Files, lines, named constants and files over 300 lines of each room of the package and the core.

python -m tools.sizes
python -m tools.sizes src/seatrial/identification
"""

import ast
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LONG = 300  # lines of a file
FOLDERS = ("src/seatrial", "core/include/seatrial", "core/bindings", "core/tests")


def constants(path: Path) -> int:
    """Names in capitals that a Python file assigns at its top level."""
    if path.suffix != ".py":
        return 0
    names = []
    for node in ast.parse(path.read_text()).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        flat = [e for t in targets for e in (t.elts if isinstance(t, ast.Tuple) else [t])]
        names += [e.id for e in flat if isinstance(e, ast.Name) and e.id.isupper()]
    return len(names)


def row(folder: Path) -> tuple[str, int, int, int, int]:
    """Name, files, lines, constants, long files."""
    files = [p for p in sorted(folder.rglob("*")) if p.suffix in {".py", ".hpp", ".cpp"}]
    lines = [len(p.read_text().splitlines()) for p in files]
    long = sum(n > LONG for n in lines)
    name = str(folder.relative_to(ROOT))
    return name, len(files), sum(lines), sum(map(constants, files)), long


def main(given: list[str]) -> None:
    """A line for each folder below those given."""
    print(f"{'folder':<44}{'files':>7}{'lines':>8}{'constants':>11}{'long':>6}")
    for top in map(Path, given or FOLDERS):
        inner = [
            p for p in sorted((ROOT / top).iterdir()) if p.is_dir() and any(p.rglob("*.[ph]*"))
        ]
        for folder in (*(p for p in inner if p.name != "__pycache__"), ROOT / top):
            name, files, lines, named, long = row(folder)
            print(f"{name:<44}{files:>7}{lines:>8}{named:>11}{long:>6}")


if __name__ == "__main__":
    main(sys.argv[1:])
