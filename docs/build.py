"""Build the site: python docs/build.py [--fast]

It takes `pip install ".[docs]"`, no network, and leaves the pages in build/docs/html. Sources are the Markdown pages of
docs/, and what `docs/site/pages.py` generates from the package: reference, gallery, results. ``--fast`` runs neither
tutorials nor gallery. A warning fails the build.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
OUT = ROOT / "build" / "docs"
PARTS = (".md", ".txt", ".png", ".webp", ".svg", ".csv", ".json", ".toml", ".rst")
"""Files of docs/ that pages consist of."""


def main(arguments: list[str]) -> int:
    """Write the sources and run Sphinx over them; the exit code of Sphinx."""
    sys.path[:0] = [str(DOCS / "site"), str(ROOT / "src")]
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    os.environ["GELCONE_DOCS_FAST"] = str(int("--fast" in arguments))
    import live
    import pages
    from sphinx.cmd.build import main as sphinx

    source, begun = OUT / "source", time.process_time()
    written = set(pages.write(pages.all_pages(ROOT, results="--fast" not in arguments), source))
    for path in DOCS.rglob("*"):
        name = path.relative_to(DOCS)
        if path.suffix in PARTS and name.parts[0] != "site":
            written.add(copied(path, source / name))
    for path in (DOCS / "site").rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            written.add(copied(path, source / path.relative_to(DOCS / "site")))
    (source / "_static" / "live.html").write_text(live.live(), encoding="utf-8")
    written.add(source / "_static" / "live.html")
    for path in source.rglob("*"):  # of an earlier build; what the gallery made belongs to it
        if path.is_file() and path not in written and path.relative_to(source).parts[0] != "gallery":
            path.unlink()
    for path in sorted((p for p in (source / "examples").rglob("*") if p.is_dir()), reverse=True):
        if not any(path.iterdir()):  # a store that an example wrote
            path.rmdir()
    jobs = [str(source), str(OUT / "html"), "-d", str(OUT / "doctrees")]
    code = sphinx(["-W", "--keep-going", "-n", "-q", "-b", "html", *jobs])
    times = os.times()
    print(f"{OUT / 'html' / 'index.html'}: {times.user + times.children_user - begun:.0f} s of processor")
    return code


def copied(path: Path, to: Path) -> Path:
    """Copy a file with its time, so that Sphinx reads again only what has changed."""
    to.parent.mkdir(parents=True, exist_ok=True)
    if not to.exists() or to.stat().st_mtime != path.stat().st_mtime:
        shutil.copy2(path, to)
    return to


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
