"""The page of the league: gathers it from the record and pours it into the template."""

from __future__ import annotations

import re
from dataclasses import dataclass

from markupsafe import Markup

from reports.league_plots import growth_plots, looks, picture, work_plot
from reports.notation import NO_BREAK, THIN, number
from reports.plots import MARKERS, VARIABLES
from reports.template import rendered
from validation.check import DISAGREEMENTS
from validation.league.cells import ANSWERED, CANNOT, Cell
from validation.league.record import EngineRow, League, TaskRow
from validation.record import FAILS

SINGLE = 2.0**-24  # of a rounding in single precision
BANDS = (
    (1.0, "good", "up to 1"),
    (10.0, "near", "up to 10"),
    (100.0, "far", "up to 100"),
    (float("inf"), "wrong", "more"),
)


@dataclass
class Shown:
    """A cell of the matrix, and its row in the evidence."""

    engine: EngineRow
    cell: Cell
    band: str  # one of BANDS', or "cannot", "broken"
    text: str
    holds: bool  # the claim's tolerance, or what single precision allows
    best: Cell | None  # the least error of those tried
    row: str  # anchor
    key: Markup


@dataclass
class Section:
    """A task with all that is known of it."""

    task: TaskRow
    anchor: str
    name: str
    shown: list[Shown]
    plot: Markup | None
    growth: list[Markup]
    picture: Markup | None

    @property
    def replayed(self) -> str:
        """Return an engine that answers: the host, if it does."""
        able = [one.engine for one in self.shown if one.cell.state == ANSWERED]
        return next((one.name for one in able if one.is_host), able[0].name if able else "ENGINE")


def page(league: League) -> str:
    """Return the whole page; the same record gives the same text."""
    names = [one.name for one in league.engines]
    keys = {name: _key(*look) for name, look in looks(names).items()}
    families: dict[str, list[Section]] = {}
    for task in league.tasks:
        cells = [cell for cell in league.cells if cell.task == task.id]
        anchor = re.sub(r"\W+", "-", task.id)
        shown = [_shown(task, engine, cells, anchor, keys[engine.name]) for engine in league.engines]
        plot, drawn = work_plot(task, cells, names), picture(task.bodies)
        growth = [Markup(one) for one in growth_plots(task, cells, names)]
        name = task.id.partition(".")[2].replace("_", " ")
        section = Section(task, anchor, name, shown, plot and Markup(plot), growth, drawn and Markup(drawn))  # type: ignore[arg-type]
        families.setdefault(task.family, []).append(section)
    asked = {cell.engine for cell in league.cells if cell.state == ANSWERED}
    sections = [one for rows in families.values() for one in rows]
    return rendered(
        "league.html.jinja",
        league=league,
        families=families,
        bands=BANDS,
        answered=len(asked),
        plots=sum(one.plot is not None for one in sections),
        keys=keys,
    )


def _shown(task: TaskRow, engine: EngineRow, cells: list[Cell], anchor: str, key: Markup) -> Shown:
    own = [cell for cell in cells if cell.engine == engine.name]
    usual = next((cell for cell in own if cell.is_usual), Cell(task.id, engine.name, 1.0, 1.0, why="it was not asked"))
    told = [cell for cell in own if cell.error is not None]
    best = min(told, key=lambda cell: cell.error or 0.0, default=None)
    row = f"{anchor}-{re.sub(r'[^A-Za-z0-9]+', '-', engine.name)}"
    if usual.state == FAILS:
        return Shown(engine, usual, "broken", "✕", False, best, row, key)
    if usual.state != ANSWERED or usual.error is None:
        return Shown(engine, usual, "cannot", "–" if usual.state == CANNOT else "?", False, None, row, key)
    times = usual.error / task.matters
    band = next(name for most, name, _ in BANDS if times <= most)
    rounding = task.roundings * SINGLE if engine.precision == "single" else 0.0
    holds = usual.error <= max(task.tolerance, rounding)
    return Shown(engine, usual, band, error_of(task, usual), holds, best, row, key)


def error_of(task: TaskRow, cell: Cell) -> str:
    """Return an error as the matrix shows it: in what matters, or how many answers are wrong."""
    assert cell.error is not None
    if task.unit == DISAGREEMENTS:
        wrong = round(cell.error * cell.n)
        return f"{wrong}{NO_BREAK}of{NO_BREAK}{cell.n}" if wrong else "0"
    times = cell.error / task.matters
    if times == 0.0:
        return "0"
    if times < 0.01:
        return f"<{THIN}0.01"
    return number(times, 2)


def _key(colour: str, marker: str) -> Markup:
    return Markup('<span style="color: var({})">{}</span>').format(VARIABLES[colour], MARKERS[marker])
