"""Gallery of the examples: each runs when the pages are built, and leaves its pictures and prints.

They are kept in build/gallery, and run anew when an example, or the core, has changed.
"""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import trimesh
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.display import status_iterator
from sphinx.util.docutils import SphinxDirective

import softbody
from softbody.compiler.core_digest import CORE_DIGEST

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RAN = ROOT / "build" / "gallery"
PART = "part.stl"  # the mesh file that squeeze_part takes


def run_examples(app: Sphinx) -> None:
    """Run those examples that have not been run as they are now."""
    stale = [source for source in EXAMPLES if _kept_digest(source) != _digest(source)]
    for source in status_iterator(
        stale, "running examples … ", "green", len(stale), stringify_func=lambda each: each.stem
    ):
        run(source)


def run(source: Path) -> None:
    """Run one example in a folder of its own; raises ExtensionError, with what it said, if it fails."""
    folder = RAN / source.stem
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    ring = softbody.torus(0.1, 0.04, 24, 12)
    trimesh.Trimesh(ring.vertices, ring.triangles).export(folder / PART)
    own = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"} | {"MPLBACKEND": "agg"}
    done = subprocess.run([sys.executable, str(source), PART], cwd=folder, env=own, capture_output=True, text=True)
    if done.returncode:
        raise ExtensionError(f"{source.name} failed:\n{done.stderr}")
    (folder / "printed.txt").write_text(done.stdout, encoding="utf-8")
    (folder / "digest").write_text(_digest(source), encoding="utf-8")


def _digest(source: Path) -> str:
    return hashlib.sha256(CORE_DIGEST.encode() + source.read_bytes()).hexdigest()


def _kept_digest(source: Path) -> str | None:
    kept = RAN / source.stem / "digest"
    return kept.read_text(encoding="utf-8") if kept.exists() else None


def pictures(source: Path) -> list[str]:
    """Return the pictures and films that an example has left, as pages refer to them."""
    found = [path for path in sorted((RAN / source.stem).iterdir()) if path.suffix in (".png", ".webp")]
    return [f"../build/gallery/{source.stem}/{path.name}" for path in found]


class Tiles(SphinxDirective):
    """`{tiles}`: a picture of each example that draws, to be chosen from at one look."""

    def run(self) -> list[nodes.Node]:
        """Return the pictures, as links to the sections."""
        tiles = nodes.container(classes=["tiles"])
        for source in (each for each in EXAMPLES if pictures(each)):
            image, name = nodes.image(uri=pictures(source)[0], alt=""), nodes.inline("", title(source))
            tiles += nodes.paragraph("", "", nodes.reference("", "", image, name, refuri=f"#{anchor(source)}"))
        return [tiles]


class Gallery(SphinxDirective):
    """`{gallery}`: a section for each example."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        text = "\n\n".join(section(source) for source in EXAMPLES)
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def anchor(source: Path) -> str:
    """Return the name of an example's section in the address of the page."""
    return source.stem.replace("_", "-")


def title(source: Path) -> str:
    """Return the name of an example in words."""
    return source.stem.replace("_", " ").capitalize()


def section(source: Path) -> str:
    """Return what is shown of one example, in Markdown."""
    said = ast.get_docstring(ast.parse(source.read_text(encoding="utf-8"))) or ""
    parts = [f"({anchor(source)})=\n## {title(source)}", said.replace("`", "")]
    parts += [f"![{title(source)}]({uri})" for uri in pictures(source)]
    printed = (RAN / source.stem / "printed.txt").read_text(encoding="utf-8").strip()
    parts += [f"It prints\n\n```text\n{printed}\n```"] if printed else []
    return "\n\n".join([*parts, f"```{{literalinclude}} ../examples/{source.name}\n:language: python\n:lines: 3-\n```"])


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the examples before anything is read, and add the directives."""
    app.connect("builder-inited", run_examples)
    app.add_directive("tiles", Tiles)
    app.add_directive("gallery", Gallery)
    return {"parallel_read_safe": True}
