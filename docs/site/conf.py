"""Sphinx configuration of the site; `docs/build.py` runs it."""

from __future__ import annotations

import hashlib
import os
import sys
import zlib
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import gelcone  # noqa: E402

HEAD = """# Sphinx inventory version 2
# Project: {}
# Version:
# The remainder of this file is compressed using zlib.
"""
FAST = os.environ.get("GELCONE_DOCS_FAST") == "1"


def inventory(text: str, folder: Path) -> dict[str, tuple[str, str]]:
    """Inventories of other projects from the few names that are linked, so that the site builds without a network."""
    found: dict[str, tuple[str, str]] = {}
    for block in text.strip().split("\n\n"):
        project, address, *names = block.splitlines()
        path = folder / f"{project}.inv"
        path.write_bytes(HEAD.format(project).encode() + zlib.compress("\n".join([*names, ""]).encode()))
        found[project] = (address, str(path))
    return found


def sources_hash() -> str:
    """A name that changes with the package: a tutorial runs again when gelcone does something else."""
    found = hashlib.sha256()
    for path in sorted(Path(gelcone.__file__).parent.rglob("*.py")):
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


PAGES = {"../CONTRIBUTING.md": "project/contributing.md", "measured/vhb": "measured/vhb/README.md"}
"""Files of the repository, as guides link them, and their pages here."""


def links(app: Any, name: str, source: list[str]) -> None:
    """Lead links to files of the repository to their pages here."""
    for path, page in {
        "../CONTRIBUTING.md": "project/contributing.md",
        "measured/vhb": "measured/vhb/README.md",
    }.items():
        source[0] = source[0].replace(f"]({path})", f"]({page})")
    source[0] = source[0].replace("[measured](measured)", "`docs/measured`")
    source[0] = source[0].replace("[measured/pump](measured/pump)", "`docs/measured/pump`")
    if name.startswith("measured/"):
        source[0] = f"---\norphan: true\n---\n{source[0]}"


def setup(app: Any) -> None:
    """Connect."""
    app.connect("source-read", links)


project, author, copyright = "gelcone", "The gelcone developers", "the gelcone developers, BSD-3-Clause"
release = version = gelcone.__version__
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.intersphinx",
    "sphinx.ext.viewcode",
    "docstring_form",
    "formulas",
    "numpydoc",
    "myst_nb",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb"}
exclude_patterns = ["examples", "gallery/*.ipynb", "gallery/*.py", "**/sg_execution_times.rst", "site"]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "off" if FAST else "cache"
nb_execution_cache_path = str(HERE.parent / "notebooks" / sources_hash())
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
autodoc_typehints = "none"
autodoc_preserve_defaults = True  # `xp=np`, not where NumPy lies
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
default_role = "code"
intersphinx_mapping = inventory((HERE / "inventory.txt").read_text(encoding="utf-8"), HERE)
html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = f"gelcone {release}"
html_theme_options = {
    "navbar_align": "left",
    "show_toc_level": 2,
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": {"**": ["page-toc"], "validation": []},  # whose tables are wide
    "use_edit_page_button": False,
    "show_prev_next": False,
}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
sphinx_gallery_conf = {
    "examples_dirs": ["examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r".*\.py",
    "ignore_pattern": r"__init__\.py",
    "download_all_examples": False,
    "remove_config_comments": True,
    "plot_gallery": not FAST,
    "run_stale_examples": False,
    "image_scrapers": ("figures.figures",),
    "reset_modules": (),
    "backreferences_dir": None,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "copyfile_regex": r".*\.rst",
}
