"""A benchmark is what its file says of it, and nothing else has to know of the file."""

from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

from benchmarks import conftest, suite

FILES = [path.stem for path in Path("benchmarks/suite").glob("bench_*.py")]


def on_page(level: str) -> list[str]:
    items = [SimpleNamespace(module=import_module(f"benchmarks.suite.{name}")) for name in FILES]
    options = {"--level": level, "--page": True}
    conftest.pytest_collection_modifyitems(SimpleNamespace(getoption=options.get), items)
    return [item.module.__name__.rpartition(".")[2] for item in items]


def test_the_page_has_all_files_the_step_first_and_at_level_quick_alone() -> None:
    assert on_page("quick") == ["bench_step"]
    assert on_page("standard")[0] == "bench_step"
    assert sorted(on_page("standard")) == sorted(FILES)


def test_a_file_that_cannot_be_imported_is_named_and_costs_its_own_goals_only(monkeypatch, capsys) -> None:
    def import_but_boxes(name: str):
        if name.endswith("bench_boxes"):
            raise ImportError("there is no fcl")
        return import_module(name)

    count = len(suite.goals())
    monkeypatch.setattr(suite.importlib, "import_module", import_but_boxes)
    assert len(suite.goals()) == count - 2
    assert capsys.readouterr().err == "bench_boxes.py has no goals here: there is no fcl\n"
