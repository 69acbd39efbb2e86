"""Plots of the league: error against cost, an engine a line; and the boxes that a task begins with."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import NullLocator

from reports.notation import number, power_of_ten
from reports.plots import MARKERS, MUTED, SERIES, svg
from validation.check import DISAGREEMENTS
from validation.league.cells import Cell
from validation.league.record import Drawn, TaskRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST = 1e-13  # of what matters: errors below are drawn there
AZIMUTH, ELEVATION = math.radians(-65.0), math.radians(14.0)  # from where boxes are seen
WIDE, HIGH, EDGE = 400, 230, 20  # of a picture, in its own units


def looks(engines: list[str]) -> dict[str, tuple[str, str]]:
    """Return the colour and the marker of each engine, the same in all plots."""
    markers, shifts = list(MARKERS), len(SERIES)
    return {name: (SERIES[i % shifts], markers[(i + i // shifts) % len(markers)]) for i, name in enumerate(engines)}


def error_name(task: TaskRow) -> str:
    """Return what an axis of errors shows."""
    if task.unit == DISAGREEMENTS:
        return "wrong answers in a thousand"
    return "largest error" + (f", in {number(task.matters)}" if task.matters != 1.0 else "") + f" {task.unit}"


def work_plot(task: TaskRow, cells: list[Cell], engines: list[str]) -> str | None:
    """Return errors against costs, as SVG; None if fewer than two can be drawn."""
    rows = [cell for cell in cells if cell.error is not None and cell.costs]
    if len(rows) < 2:
        return None
    return svg(f"league {task.id}", lambda axes: _draw(axes, task, rows, engines))


def _draw(axes: Axes, task: TaskRow, cells: list[Cell], engines: list[str]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for engine, (colour, marker) in looks(engines).items():
        own = [cell for cell in cells if cell.engine == engine]
        lines = (
            ("-", [one for one in own if one.iterations == 1.0]),
            ((0, (2, 2)), [one for one in own if one.steps == 1.0]),
        )
        for dashes, line in lines:
            line = sorted(line, key=lambda cell: (cell.steps, cell.iterations))
            if len(line) > 1:
                axes.plot(*zip(*(_point(task, cell) for cell in line)), color=colour, linewidth=1.2, linestyle=dashes)
        for cell in own:
            size, face = (7, colour) if cell.is_usual else (4, "none")
            axes.plot(*_point(task, cell), color=colour, marker=marker, markersize=size, markerfacecolor=face)
    axes.axhline(1.0, color=MUTED, linewidth=0.8, linestyle=(0, (1, 3)))
    points = np.array([_point(task, cell) for cell in cells])
    _decades(axes.set_xlim, axes.set_xticks, points[:, 0])
    _decades(axes.set_ylim, axes.set_yticks, np.append(points[:, 1], 1.0))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="both")
    axes.set_axisbelow(True)
    axes.set_xlabel(f"seconds of the processor per {task.cost_of}")
    axes.text(-0.13, 1.08, error_name(task), transform=axes.transAxes, parse_math=False)


def growth_plots(task: TaskRow, cells: list[Cell], engines: list[str]) -> list[str]:
    """Return how costs and errors grow with the number of bodies, as two SVGs; none where it is always the same."""
    rows = {cell.engine: np.array(cell.growth) for cell in cells if cell.is_usual and cell.growth}
    if not rows:
        return []
    cost, error = f"seconds of the processor per {task.cost_of}", error_name(task)
    return [
        svg(f"{name} {task.id}", lambda axes, k=k, name=name, by=by: _draw_growth(axes, rows, engines, k, name, by))  # type: ignore[misc]
        for k, name, by in ((1, cost, 1.0), (2, error, task.matters))
    ]


def _draw_growth(
    axes: Axes, rows: dict[str, np.ndarray], engines: list[str], column: int, name: str, unit: float
) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    values = {engine: np.maximum(row[:, column] / unit, LEAST) for engine, row in rows.items()}
    for engine, (colour, marker) in looks(engines).items():
        if engine in rows:
            axes.plot(rows[engine][:, 0], values[engine], color=colour, marker=marker, markersize=5, linewidth=1.2)
    _decades(axes.set_xlim, axes.set_xticks, np.concatenate([row[:, 0] for row in rows.values()]), 0.1)
    _decades(axes.set_ylim, axes.set_yticks, np.concatenate(list(values.values())))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="both")
    axes.set_xlabel("bodies")
    axes.text(-0.13, 1.08, name, transform=axes.transAxes, parse_math=False)


def _decades(limit: Callable[..., Any], ticks: Callable[..., Any], values: np.ndarray, room: float = 0.3) -> None:
    """Give a logarithmic axis its ends and its ticks."""
    low, high = math.log10(values.min()) - room, math.log10(values.max()) + room
    limit(10.0**low, 10.0**high)
    stride = max(1, math.ceil((high - low) / 6))
    powers = [p for p in range(math.ceil(low), math.floor(high) + 1) if p % stride == 0]
    ticks([10.0**p for p in powers], [power_of_ten(p) for p in powers])


def _point(task: TaskRow, cell: Cell) -> tuple[float, float]:
    assert cell.error is not None
    return cell.costs[1], max(cell.error / task.matters, LEAST)


def picture(bodies: list[Drawn]) -> str | None:
    """Return bodies as they are seen from the front, a little from above, with arrows for what moves, as SVG."""
    if not bodies:
        return None
    sight = np.array([math.cos(AZIMUTH), math.sin(AZIMUTH), math.tan(ELEVATION)]) * math.cos(ELEVATION)
    right = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
    screen = np.array([right, np.cross(sight, right)])  # across and up
    places = [np.array(body.vertices) for body in bodies]
    flat = np.concatenate(places) @ screen.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = float(((np.array([WIDE, HIGH]) - 2.0 * EDGE) / np.maximum(high - low, 1e-9)).min())

    def on_paper(points: np.ndarray) -> np.ndarray:
        across = points @ screen.T - 0.5 * (low + high)
        return np.array([WIDE / 2, HIGH / 2]) + scale * across * [1.0, -1.0]

    fastest = max(float(np.linalg.norm(body.velocity)) for body in bodies)
    parts = []
    for k in sorted(range(len(bodies)), key=lambda k: float(places[k].mean(axis=0) @ sight)):  # what is behind first
        parts += _faces(places[k], bodies[k].faces, sight, on_paper)
        speed = np.array(bodies[k].velocity)
        if fastest and np.linalg.norm(speed) > 0.05 * fastest:
            start = places[k].mean(axis=0)
            parts.append(_arrow(*on_paper(np.array([start, start + speed / fastest * 60.0 / scale]))))
    return f'<svg viewBox="0 0 {WIDE} {HIGH}" aria-hidden="true">{"".join(parts)}</svg>'


def _faces(
    places: np.ndarray, faces: list[list[int]], sight: np.ndarray, on_paper: Callable[[np.ndarray], np.ndarray]
) -> list[str]:
    """Return the faces that are seen, the farthest first."""
    seen = []
    for face in faces:
        corners = places[face]
        if np.cross(corners[1] - corners[0], corners[2] - corners[1]) @ sight > 0.0:
            drawn = f'<path d="M{"L".join(_pairs(on_paper(corners)))}Z"/>'
            seen.append((float(corners.mean(axis=0) @ sight), drawn))
    return [path for _, path in sorted(seen)]


def _arrow(start: np.ndarray, tip: np.ndarray) -> str:
    along = tip - start
    along *= 6.0 / max(float(np.linalg.norm(along)), 1e-9)
    aside = 0.6 * np.array([-along[1], along[0]])
    head = "L".join(_pairs(np.array([tip - along + aside, tip, tip - along - aside])))
    return f'<path class="way" d="M{"L".join(_pairs(np.array([start, tip])))}M{head}"/>'


def _pairs(points: np.ndarray) -> list[str]:
    return [f"{x:.1f} {y:.1f}" for x, y in points]
