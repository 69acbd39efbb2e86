"""Pages built by Sphinx, from Markdown, the core's docstrings and the claims; `make docs`."""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "extensions")]
os.environ["NUMBA_DISABLE_JIT"] = "1"  # kernels are read here, not run: as functions, with their signatures

import softbody  # noqa: E402

project = "softbody"
release = softbody.__version__
copyright = "the softbody maintainers; MIT"

extensions = ["myst_parser", "sphinx.ext.autodoc", "claims", "gallery", "mathml", "plain_docstrings", "rooms"]
myst_enable_extensions = ["dollarmath", "smartquotes"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}  # and not all that it stands for
autodoc_typehints_format = "short"
default_role = "code"

html_theme = "furo"
html_title = "softbody"
html_static_path = ["static"]
html_css_files = ["own.css"]
html_show_sourcelink = False
