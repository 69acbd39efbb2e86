"""Whatever Python the README and the pages in docs/ show runs as it stands, block after block."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
