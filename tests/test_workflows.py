"""What a public host reads is well formed, and asks for what is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = [*sorted((ROOT / ".github").rglob("*.yml")), ROOT / ".readthedocs.yaml", ROOT / ".pre-commit-config.yaml"]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_what_a_host_reads_is_yaml(file: Path) -> None:
    yaml = pytest.importorskip("yaml")
    assert yaml.safe_load(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", [*FILES, ROOT / "Dockerfile"], ids=lambda file: file.name)
def test_every_target_and_extra_that_it_asks_for_is_there(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"(?:run: |- |RUN )make ([.\w/-]+)", text):
        assert re.search(rf"^{re.escape(target)}:", makefile, re.MULTILINE), target
    extras = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for extra in ",".join(re.findall(r'"\.\[([\w,]+)\]"', text)).split(","):
        assert not extra or re.search(rf"^{extra} = \[", extras, re.MULTILINE), extra


def test_the_forms_have_what_a_host_demands() -> None:
    yaml = pytest.importorskip("yaml")
    for file in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"):
        form = yaml.safe_load(file.read_text(encoding="utf-8"))
        assert {"name", "description", "body"} <= set(form)
        assert all(part["attributes"]["label"] for part in form["body"])
