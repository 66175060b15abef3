"""Shortest paths on a grid: A*, and the path pulled tight by line of sight.

A* is that of Hart, Nilsson and Raphael, "A Formal Basis for the Heuristic Determination of Minimum
Cost Paths" (1968), on the eight neighbours of a cell; its heuristic is the length of the path
without obstacles (octile distance).
"""

import heapq
import math
from typing import Dict, List, Tuple

import numpy as np

from flatland_navigation.grid import Cell, Grid
from flatland_server import BoolArray, FloatArray, Point

_DIAGONAL = math.sqrt(2.0)
_START_REACH = 0.5
"""Greatest distance to a free cell for a start that is too near to a wall [m]."""


class PlanningError(Exception):
    """There is no path to a goal; the message says why."""


def plan(grid: Grid, start: Point, goal: Point) -> FloatArray:
    """A short path that keeps the grid's clearance.

    A start that is too near to a wall is left on a straight line to the nearest free cell.

    Args:
        grid: free cells for the robot's centre.
        start: position of the robot [m].
        goal: where to drive [m].

    Returns:
        Corners of the path, start and goal included [m]: shape (n, 2), n >= 2.

    Raises:
        PlanningError: the goal is outside of the map, inside an obstacle, too near to a wall, or
            not connected with the start.
    """
    goal_cell = _goal_cell(grid, start, goal)
    start_cell = _start_cell(grid, start)
    # Searched backwards: a goal enclosed by walls is detected at once.
    cells = shortest_path(grid.free, goal_cell, start_cell)
    if not cells:
        _refuse_inside(grid, start, goal)
        raise PlanningError(f"there is no path from {_text(start)} to {_text(goal)}")
    middle = [grid.centre_of(cell) for cell in reversed(cells)]
    return shortcut(grid, np.array([start, *middle, goal]))


def shortest_path(free: BoolArray, start: Cell, goal: Cell) -> List[Cell]:
    """A shortest path over free cells, from cell to one of its eight neighbours.

    A diagonal step needs both cells beside it to be free.

    Args:
        free: true for free cells, shape (rows, columns).
        start: a free cell.
        goal: a free cell.

    Returns:
        The cells of the path, start and goal included; empty if they are not connected.
    """
    width = free.shape[1] + 2  # a border of blocked cells replaces checks of the bounds
    passable = np.pad(free, 1).ravel().tolist()
    goal_row, goal_column = goal[0] + 1, goal[1] + 1
    first, last = (start[0] + 1) * width + start[1] + 1, goal_row * width + goal_column

    def remaining(cell: int) -> float:
        row, column = divmod(cell, width)
        rows, columns = abs(row - goal_row), abs(column - goal_column)
        return max(rows, columns) + (_DIAGONAL - 1.0) * min(rows, columns)

    straight = (1, width, -1, -width)
    cost: Dict[int, float] = {first: 0.0}
    parent: Dict[int, int] = {}
    closed = set()
    queue: List[Tuple[float, int]] = [(remaining(first), first)]
    while queue:
        cell = heapq.heappop(queue)[1]
        if cell == last:
            return _trace(parent, cell, width)
        if cell in closed:
            continue
        closed.add(cell)
        so_far = cost[cell]
        for here, left in zip(straight, (width, -1, -width, 1)):  # and 90 degrees to the left
            if not passable[cell + here]:
                continue
            steps = [(cell + here, so_far + 1.0)]
            if passable[cell + left] and passable[cell + here + left]:
                steps.append((cell + here + left, so_far + _DIAGONAL))
            for neighbour, length in steps:
                if length < cost.get(neighbour, math.inf):
                    cost[neighbour] = length
                    parent[neighbour] = cell
                    heapq.heappush(queue, (length + remaining(neighbour), neighbour))
    return []


def shortcut(grid: Grid, path: FloatArray) -> FloatArray:
    """A path without the corners that a straight line over free cells leaves out.

    Args:
        grid: free cells for the lines of the path.
        path: shape (n, 2) [m].

    Returns:
        Some of its points, the first and the last among them: shape (m, 2), 2 <= m <= n.
    """
    corners = [0]
    for index in range(1, len(path) - 1):
        if not grid.line_is_free(tuple(path[corners[-1]]), tuple(path[index + 1])):
            corners.append(index)
    return np.asarray(path[[*corners, len(path) - 1]])


def _refuse_inside(grid: Grid, start: Point, goal: Point) -> None:
    if grid.encloses(goal, start):
        raise PlanningError(f"the goal {_text(goal)} is inside an obstacle")


def _goal_cell(grid: Grid, start: Point, goal: Point) -> Cell:
    cell = grid.cell_of(goal)
    if cell is None:
        left, bottom, right, top = grid.bounds
        raise PlanningError(
            f"the goal {_text(goal)} is outside of the map, which spans x from {left:g} to "
            f"{right:g} and y from {bottom:g} to {top:g}"
        )
    distance = grid.distance_to_wall(goal)
    if distance < grid.clearance:
        _refuse_inside(grid, start, goal)
        raise PlanningError(
            f"the goal {_text(goal)} is {distance:.2f} m from a wall; "
            f"the robot's centre must be at least {grid.clearance:.2f} m from walls"
        )
    if not grid.free[cell]:
        # A wall is too near to a part of the cell only, or an obstacle blocks the cell.
        nearest = grid.nearest_free(goal, 2 * grid.resolution)
        if nearest is None:
            raise PlanningError(f"there is no room for the robot at the goal {_text(goal)}")
        cell = nearest
    return cell


def _start_cell(grid: Grid, start: Point) -> Cell:
    cell = grid.cell_of(start)
    if cell is None:
        raise PlanningError(f"the robot is outside of the map, at {_text(start)}")
    if not grid.free[cell]:
        nearest = grid.nearest_free(start, grid.clearance + _START_REACH)
        if nearest is None:
            raise PlanningError(f"there is no room around the robot, at {_text(start)}")
        cell = nearest
    return cell


def _trace(parent: Dict[int, int], cell: int, width: int) -> List[Cell]:
    """The cells from the start to a cell, without the border."""
    cells = [cell]
    while cell in parent:
        cell = parent[cell]
        cells.append(cell)
    return [(c // width - 1, c % width - 1) for c in reversed(cells)]


def _text(point: Point) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f})"
