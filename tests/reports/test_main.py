"""Does `python -m reports FOLDER` write a page, or say what is wrong?"""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from reports.__main__ import main
from validation.record import write_report


def test_the_page_is_written_beside_the_record(tmp_path, report):
    write_report(report, tmp_path / "report.json")
    done = CliRunner().invoke(main, [str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert done.output.strip().endswith("index.html")
    assert "claims FAIL" in (tmp_path / "index.html").read_text(encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["badge.svg", "index.html", "report.json"]


def test_a_missing_record_is_named(tmp_path):
    done = CliRunner().invoke(main, [str(tmp_path)])
    assert done.exit_code == 2
    assert "report.json does not exist" in done.output


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not JSON"),
        ("[]", "has schema 'list'"),
        (json.dumps({"schema": "softbody-report/0"}), "softbody-report/0"),
        (json.dumps({"schema": "softbody-report/1"}), "is damaged"),
        (json.dumps({"schema": "softbody-report/1", "claims": [], "timings": []}), "is damaged"),
    ],
)
def test_a_record_that_is_none_is_refused(tmp_path, text, words):
    (tmp_path / "report.json").write_text(text)
    done = CliRunner().invoke(main, [str(tmp_path)])
    assert done.exit_code == 2
    assert words in done.output
    assert not (tmp_path / "index.html").exists()


def test_a_missing_folder_is_wrong_usage(tmp_path):
    assert CliRunner().invoke(main, [str(tmp_path / "nowhere")]).exit_code == 2


def test_help_does_not_wait_for_matplotlib():
    code = "import sys; from reports.__main__ import main; main(['--help'], standalone_mode=False)"
    code += "; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "FOLDER" in done.stdout
    assert done.stdout.strip().endswith("False")
