"""Plots of the league: error against cost, an engine a line; and the boxes that a task begins with."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import NullLocator

from reports.notation import number, power_of_ten
from reports.plots import MARKERS, MUTED, SERIES, svg
from validation.league.cells import Cell
from validation.league.record import Drawn, TaskRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST = 1e-13  # of what matters: errors below are drawn there
AZIMUTH, ELEVATION = math.radians(-65.0), math.radians(14.0)  # from where boxes are seen
WIDE, HIGH = 400, 230  # of a picture, in its own units


def looks(engines: list[str]) -> dict[str, tuple[str, str]]:
    """Return the colour and the marker of each engine, the same in all plots."""
    markers, shifts = list(MARKERS), len(SERIES)
    return {name: (SERIES[i % shifts], markers[(i + i // shifts) % len(markers)]) for i, name in enumerate(engines)}


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
    axes.text(-0.13, 1.08, f"error, in {number(task.matters)} {task.unit}", transform=axes.transAxes, parse_math=False)


def growth_plots(task: TaskRow, cells: list[Cell], engines: list[str]) -> list[str]:
    """Return how costs and errors grow with the number of bodies, as two SVGs; none where it is always the same."""
    rows = {cell.engine: np.array(cell.growth) for cell in cells if cell.is_usual and cell.growth}
    if not rows:
        return []
    cost, error = f"seconds of the processor per {task.cost_of}", f"error, in {number(task.matters)} {task.unit}"
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
    axes.set_xlabel("boxes")
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


# Faces of a box whose corners are numbered 4 x + 2 y + z, counter-clockwise from outside.
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def picture(boxes: list[Drawn]) -> str | None:
    """Return boxes as they are seen from the front, a little from above, with arrows for what moves, as SVG."""
    if not boxes:
        return None
    sight = np.array(
        [math.cos(AZIMUTH) * math.cos(ELEVATION), math.sin(AZIMUTH) * math.cos(ELEVATION), math.sin(ELEVATION)]
    )
    right = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
    screen = np.array([right, np.cross(right, -sight)])  # across and up, seen from the front
    corners = np.array([box.corners for box in boxes])
    flat = corners @ screen.T
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    scale = min((WIDE - 40) / max(high[0] - low[0], 1e-9), (HIGH - 40) / max(high[1] - low[1], 1e-9))
    middle = 0.5 * (low + high)

    def on_paper(places: np.ndarray) -> np.ndarray:
        return np.array([WIDE / 2, HIGH / 2]) + scale * (places @ screen.T - middle) * [1.0, -1.0]

    parts, fastest = [], max(float(np.linalg.norm(box.velocity)) for box in boxes)
    for k in np.argsort(corners.mean(axis=1) @ sight):  # what is behind first
        for face in FACES:
            a, b, c, _ = corners[k][list(face)]
            if np.cross(b - a, c - b) @ sight > 0.0:
                parts.append(f'<path d="M{"L".join(_pairs(on_paper(corners[k][list(face)])))}Z"/>')
        speed = np.array(boxes[k].velocity)
        if fastest and np.linalg.norm(speed) > 0.05 * fastest:
            start = corners[k].mean(axis=0)
            tip = start + speed / fastest * 0.25 * (high - low).max()
            (from_x, from_y), (to_x, to_y) = on_paper(start), on_paper(tip)
            along = np.array([to_x - from_x, to_y - from_y])
            along = 6.0 * along / max(float(np.linalg.norm(along)), 1e-9)
            wings = [np.array([to_x, to_y]) - along + s * along[::-1] * [1.0, -1.0] * 0.6 for s in (-1.0, 1.0)]
            head = _pairs(np.array([wings[0], [to_x, to_y], wings[1]]))
            parts.append(f'<path class="way" d="M{from_x:.1f} {from_y:.1f}L{to_x:.1f} {to_y:.1f}M{"L".join(head)}"/>')
    return f'<svg viewBox="0 0 {WIDE} {HIGH}" aria-hidden="true">{"".join(parts)}</svg>'


def _pairs(points: np.ndarray) -> list[str]:
    return [f"{x:.1f} {y:.1f}" for x, y in points]
