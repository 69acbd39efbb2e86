"""What is stored comes back; two writers, damage and a full disk lose nothing but what is damaged."""

from __future__ import annotations

import json
import multiprocessing
import sqlite3

import click
import pytest

from benchmarks.exchange import export, import_file
from benchmarks.history import History, run_record


@pytest.fixture
def history(tmp_path):
    said = []
    history = History(tmp_path / "folder" / "history.sqlite", said.append)
    history.heard = said
    return history


def days(make_document, *numbers, **more):
    return [run_record(make_document(f"2030-01-{number:02}T00:00:00", **more)) for number in numbers]


def test_runs_come_back_in_the_order_of_time_with_all_rounds(history, make_document):
    assert history.add(days(make_document, 2)) == 1
    assert history.add(days(make_document, 1)) == 1
    assert [record.started[8:10] for record in history.records()] == ["01", "02"]
    assert history.records()[0].document == make_document("2030-01-01T00:00:00")


def test_a_history_that_is_not_there_is_empty(history):
    assert history.records() == []


def test_the_same_run_is_stored_once(history, make_document):
    assert history.add(days(make_document, 1)) == 1
    assert history.add(days(make_document, 1, 2)) == 1


def test_other_machines_are_kept_apart(history, make_document):
    history.add(days(make_document, 1) + days(make_document, 2, brand="Another CPU"))
    first, second = history.records()
    assert first.machine != second.machine
    assert history.records(machine=second.machine) == [second]


def _add_twenty(path, first, make):
    for day in range(20):
        History(path).add([run_record(make(f"{first}-01-{day + 1:02}"))])


def test_two_writers_at_once_both_store_everything(history, make_document):
    context = multiprocessing.get_context("fork")
    writers = [context.Process(target=_add_twenty, args=(history.path, year, make_document)) for year in (2030, 2031)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join(60)
    assert len(history.records()) == 40


@pytest.mark.parametrize("damage", [b"", b"not compressed", b"x\x9c+\x01\x00"])
def test_a_damaged_row_is_left_out_and_said(history, make_document, damage):
    history.add(days(make_document, 1, 2))
    with sqlite3.connect(history.path) as database:
        database.execute("UPDATE record SET document = ? WHERE started LIKE '2030-01-01%'", (damage,))
    assert [record.started[8:10] for record in history.records()] == ["02"]
    assert "2030-01-01" in history.heard[0]
    assert "damaged" in history.heard[0]


def test_a_damaged_file_is_put_aside_and_a_new_one_begun(history, make_document):
    history.path.parent.mkdir()
    history.path.write_bytes(b"this was a history once" * 100)
    assert history.records() == []
    assert history.add(days(make_document, 1)) == 1
    assert "put aside" in history.heard[0]
    (aside,) = history.path.parent.glob("*.damaged-*")
    assert aside.read_bytes().startswith(b"this was a history once")


def test_of_a_file_that_is_damaged_in_part_the_rest_is_kept(history, make_document):
    history.add(days(make_document, *range(1, 29)))
    content = bytearray(history.path.read_bytes())
    content[-4096:] = bytes(4096)  # a page of rows
    history.path.write_bytes(content)
    kept = history.records()
    assert 10 < len(kept) < 28
    assert "put aside" in history.heard[0]
    history.heard.clear()
    assert history.records() == kept
    assert history.heard == []


class FullDisk:
    """A database that takes one row, and then says that the disk is full."""

    def __init__(self, real):
        self.real, self.rows = real, 0

    def execute(self, sql, *values):
        if sql.startswith("INSERT"):
            self.rows += 1
            if self.rows == 2:
                raise sqlite3.OperationalError("database or disk is full")
        return self.real.execute(sql, *values)

    def close(self):
        self.real.close()


def test_on_a_full_disk_nothing_is_added_and_nothing_lost(history, make_document, monkeypatch):
    history.add(days(make_document, 1))
    connect = history._connect
    monkeypatch.setattr(history, "_connect", lambda: FullDisk(connect()))
    with pytest.raises(click.ClickException, match=r"disk is full.*--history"):
        history.add(days(make_document, 2, 3))
    monkeypatch.undo()
    assert [record.started[8:10] for record in history.records()] == ["01"]


@pytest.mark.parametrize("ending", ["jsonl", "json"])
def test_what_is_exported_can_be_imported(history, make_document, tmp_path, ending):
    history.add(days(make_document, 1, 2))
    written = tmp_path / f"runs.{ending}"
    count = export(history.records(), written)
    other = History(tmp_path / "other.sqlite")
    assert import_file(written, other) == count == len(other.records())
    assert other.records()[-1] == history.records()[-1]
    assert not list(tmp_path.glob(".*"))


def test_a_damaged_line_is_left_out_and_said(history, make_document, tmp_path):
    lines = [
        json.dumps(make_document("2030-01-01")),
        "{",
        json.dumps({"benchmarks": [{}]}),
        json.dumps(make_document("2030-01-02")),
    ]
    (tmp_path / "runs.jsonl").write_text("\n".join(lines))
    assert import_file(tmp_path / "runs.jsonl", history) == 2
    assert ["line 2" in history.heard[0], "line 3" in history.heard[1]] == [True, True]


def test_exports_that_cannot_be_are_refused(history, make_document, tmp_path):
    with pytest.raises(click.ClickException, match="nothing to export"):
        export([], tmp_path / "runs.json")
    history.add(days(make_document, 1))
    with pytest.raises(click.UsageError, match="jsonl"):
        export(history.records(), tmp_path / "runs.csv")
    with pytest.raises(click.ClickException, match="cannot be written"):
        export(history.records(), tmp_path / "nowhere" / "runs.json")
