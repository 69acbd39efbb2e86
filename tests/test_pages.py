"""Whatever Python the README and the pages in docs/ show runs as it stands, block after block."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import softbody
from tests.readme_example import python_blocks

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
ENDLESS = "world.view()"  # serves until Ctrl-C


@pytest.mark.parametrize("page", [page for page in PAGES if python_blocks(page)], ids=lambda page: page.stem)
def test_what_a_page_shows_runs(page, tmp_path):
    program = tmp_path / "page.py"
    program.write_text("\n".join(python_blocks(page)).replace(ENDLESS, "pass"), encoding="utf-8")
    environment = os.environ | {"MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, str(program)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr


def test_every_public_name_has_its_place_in_the_reference():
    shown = "\n".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "api").glob("*.md"))
    places = {name: getattr(softbody, name).__module__ for name in softbody.__all__ if name != "scenes"}
    missing = [
        name for name, module in places.items() if f"softbody.{name}\n" not in shown and f" {module}\n" not in shown
    ]
    assert not missing
    assert "softbody.scenes" in shown
