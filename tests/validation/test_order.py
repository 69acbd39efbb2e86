"""Claims that see many faults in little time come first, whatever is known of their time."""

import json
from dataclasses import replace

from validation import order
from validation.check import all_checks
from validation.order import soonest_first


def test_those_that_see_many_faults_in_little_time_come_first(tmp_path, monkeypatch):
    some = next(check for check in all_checks().values() if check.faults)
    slow = replace(some, id="a.slow", faults=some.faults[:1])
    quick, new = replace(slow, id="b.quick"), replace(slow, id="c.new", faults=slow.faults * 3)

    def names() -> list[str]:
        return [each.id for each in soonest_first([slow, quick, new], tmp_path)]

    assert names() == ["c.new", "a.slow", "b.quick"]  # there is no report
    (tmp_path / "report.json").write_text("{")
    assert names() == ["c.new", "a.slow", "b.quick"]  # nor one that can be read
    monkeypatch.setattr(order, "seconds_before", lambda path: {"a.slow": 9.0, "b.quick": 0.1})
    assert names() == ["b.quick", "c.new", "a.slow"]


def test_seconds_are_those_of_the_last_report(tmp_path):
    path = tmp_path / "report.json"
    assert order.seconds_before(path) == {}
    path.write_text(json.dumps({"schema": "1.0"}))
    assert order.seconds_before(path) == {}
