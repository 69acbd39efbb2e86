"""Script of three.js, which turns scenes in the page, as trimesh brings it for its own viewer."""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path

FILE = "viewer.html.template"
BEGIN, END = "/**", "THREE.TrackballControls=TrackballControls;})();"  # of three.js, and of its controls


@cache
def three_js() -> str | None:
    """Return the script (MIT licence, named in its first line), or None where trimesh is not, or has another viewer."""
    try:
        import trimesh

        with zipfile.ZipFile(Path(trimesh.__file__).parent / "resources" / "templates" / "viewer.zip") as viewer:
            text = viewer.read(FILE).decode()
        script = text[text.index(BEGIN, text.index("<script")) : text.index(END) + len(END)]
    except (ImportError, OSError, KeyError, ValueError, zipfile.BadZipFile):
        return None
    return script if "Three.js Authors" in script[:200] else None
