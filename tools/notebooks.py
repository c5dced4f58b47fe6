# SPDX-License-Identifier: MIT
"""Notebooks of `examples/notebooks`: run them, and show them in the documentation with their outputs.

python tools/notebooks.py NOTEBOOK OUT     # run it, and write it with outputs

The files are kept without outputs. As a hook of MkDocs (`hooks:` in mkdocs.yml) this runs every notebook that
a page of `docs/notebooks` stands for, and puts text and pictures in the page's place. Nothing is fetched.
A notebook that the tests have run with the same package is not run again: `build/notebooks` has its outputs.
"""

import hashlib
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nbformat import NotebookNode

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = ROOT / "examples" / "notebooks"
KEPT = ROOT / "build" / "notebooks"  # with outputs, by what they are made of
PAGES = "notebooks"  # below docs/; a page has the name of its notebook
TIMEOUT = 600  # [s] of a cell
QUIET = ["--log-level=40"]  # errors of the kernel only

_rendered: dict[str, str] = {}


def executed(path: Path) -> "NotebookNode":
    """The notebook with outputs. Raises nbclient's CellExecutionError."""
    import nbformat  # noqa: PLC0415
    from nbclient import NotebookClient  # noqa: PLC0415

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        place = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=TIMEOUT, resources=place, extra_arguments=QUIET).execute()
    return notebook


def kept(path: Path) -> Path:
    """Where its outputs are kept: a name for this notebook, this Python, this package and what it requires."""
    import seatrial._core  # noqa: PLC0415

    files = [*(ROOT / "src").rglob("*"), *(ROOT / "requirements").rglob("*")]
    package = [p for p in files if p.is_file() and p.suffix != ".pyc"]
    digest = hashlib.sha256(sys.version.encode())
    for each in (path, Path(seatrial._core.__file__), *sorted(package)):
        digest.update(f"{each}\n".encode() + each.read_bytes())
    return KEPT / f"{path.stem}-{digest.hexdigest()[:32]}.ipynb"


def keep(notebook: "NotebookNode", path: Path) -> None:
    """Keep outputs, those of an earlier state no longer."""
    import nbformat  # noqa: PLC0415

    KEPT.mkdir(parents=True, exist_ok=True)
    for old in KEPT.glob(f"{path.stem}-*.ipynb"):
        old.unlink()
    nbformat.write(notebook, kept(path))


def known_or_executed(path: Path) -> "NotebookNode":
    """The notebook with outputs: those that are kept, or new ones."""
    import nbformat  # noqa: PLC0415

    known = kept(path)
    return nbformat.read(known, as_version=4) if known.exists() else executed(path)


def as_markdown(notebook: "NotebookNode", name: str) -> tuple[str, dict[str, bytes]]:
    """The page's text, and its pictures by their paths beside it."""
    from nbconvert import MarkdownExporter  # noqa: PLC0415

    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            _best_form(output)
    resources: dict[str, Any] = {"output_files_dir": f"{name}_files"}
    text, found = MarkdownExporter().from_notebook_node(notebook, resources)
    return text, dict(found["outputs"])


def _best_form(output: Any) -> None:  # noqa: ANN401
    """HTML where there is some, without pandas' style, which is for notebooks; else the picture."""
    data = output.get("data", {})
    if "text/html" in data:
        html = data["text/html"].partition("<style scoped>")
        if html[1]:
            data["text/html"] = html[0] + html[2].partition("</style>")[2]
        data["text/html"] = "\n".join(
            line.strip() for line in data["text/html"].splitlines() if line.strip()
        )
    if "image/png" in data or "text/html" in data:
        data.pop("text/plain", None)


def on_files(files: Any, config: Any) -> Any:  # noqa: ANN401
    """Run the notebooks before links are checked; their pictures and the notebooks are files of the site."""
    from mkdocs.structure.files import File  # noqa: PLC0415

    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        text, pictures = as_markdown(known_or_executed(path), path.stem)
        link = f"*[This notebook]({path.name}), run by `make docs`.*"
        head, _, rest = text.lstrip().partition("\n")
        _rendered[f"{PAGES}/{path.stem}.md"] = f"{head}\n\n{link}\n{rest}"
        for name, content in pictures.items():
            files.append(File.generated(config, f"{PAGES}/{name}", content=content))
        files.append(File.generated(config, f"{PAGES}/{path.name}", content=path.read_text()))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:  # noqa: ANN401
    """The notebook in place of the page that stands for it."""
    return _rendered.get(page.file.src_uri, markdown)


def main() -> None:
    """One notebook, with outputs."""
    import nbformat  # noqa: PLC0415

    source, out = (Path(argument).absolute() for argument in sys.argv[1:])
    notebook = executed(source)
    nbformat.write(notebook, out)
    if source.parent == NOTEBOOKS:
        keep(notebook, source)


if __name__ == "__main__":
    main()
