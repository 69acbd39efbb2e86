"""Do figures of a run get into the README by a command, and only those of a run of all claims?"""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from reports.__main__ import main
from reports.readme import BADGE, BEGIN, END
from validation.record import Subject, write_report

ROOT = Path(__file__).parents[2]


@pytest.fixture
def command(report, tmp_path):
    """Return a function that writes the record and a README, and runs the command."""

    def run(readme: str | None = f"Before.\n{BEGIN}\nformer\n{END}\n\nAfter.\n"):
        write_report(report, tmp_path / "report.json")
        file = tmp_path / "README.md"
        (tmp_path / "docs").mkdir(exist_ok=True)
        if readme is not None:
            file.write_text(readme, encoding="utf-8")
        done = CliRunner().invoke(main, ["readme", str(tmp_path), "--file", str(file)])
        return done, file.read_text(encoding="utf-8") if file.exists() else None

    return run


def test_figures_stand_between_the_marks_and_the_rest_stays(command, report, tmp_path):
    done, text = command()
    assert done.exit_code == 0, done.output
    picture = f"![Verdict of the last run]({BADGE})"
    assert text.startswith(f"Before.\n{BEGIN}\n\n{picture}\n\nAt level standard, seed 20080101: 40 claims (")
    assert text.endswith(f"\n\n{END}\n\nAfter.\n")
    assert "former" not in text
    assert "2025" not in text, "a date"
    assert "of 40 hold" in (tmp_path / "docs" / "badge.svg").read_text(encoding="utf-8")
    assert command(text)[1] == text, "the same run writes the same"
    for claim in report.claims:
        claim.kind, claim.piece = "invariant", "core.one"
    _, text = command()
    assert "judge\n1 pieces of the core, 1 of them without a judge from outside." in text
    assert "| invariant | 40 | " in text


@pytest.mark.parametrize(
    "readme", ["no marks", BEGIN, f"{END}\n{BEGIN}\n{END}", f"{BEGIN}\n{BEGIN}\n{END}", f"{BEGIN}\n{END}\n{END}", None]
)
def test_a_readme_without_a_place_for_them_is_left_alone(command, readme):
    done, text = command(readme)
    assert done.exit_code == 2
    assert "README.md" in done.output
    assert text == readme


def test_a_run_of_some_claims_or_of_another_engine_is_refused(command, report):
    report.patterns = ["volume"]
    done, text = command()
    assert (done.exit_code, "of some claims only" in done.output, "former" in text) == (2, True, True)
    report.patterns, report.subject = [], Subject("rapier3d", "1")
    assert "about rapier3d" in command()[0].output
    report.subject, report.claims = None, []
    assert command()[0].exit_code == 2


def test_the_readme_has_the_marks_and_figures():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.count(BEGIN) == 1
    assert "At level " in text[text.index(BEGIN) : text.index(END)]
