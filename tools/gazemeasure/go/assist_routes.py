"""A route through a cluttered room, for the simulated gaze driver of the benchmark."""

from __future__ import annotations

import heapq
import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazesim.gaze_driver import Point
from gazesim.rooms import Room

_CELL_M = 0.1
_HALF_M = 2.8
_FREE_M = 0.60  # least distance of the axle: half the width, and a hand's breadth
_FAR_M = 3.0  # to the goal
_AHEAD_M = 1.2  # distance to the point of the route that the driver looks at


def route(room: Room, start: Point) -> tuple[Point, ...]:
    """Points to pass on a route to a far goal; empty when there is none."""
    grid = np.arange(-_HALF_M, _HALF_M + 1e-6, _CELL_M)
    xs, ys = np.meshgrid(grid, grid, indexing="ij")
    points = np.stack((xs.ravel(), ys.ravel()), axis=1)
    free = (_distances(points, room.body_segments()) > _FREE_M).reshape(xs.shape)
    first = _cell(start)
    costs, before = {first: 0.0}, {first: first}
    heap = [(0.0, first)]
    while heap:
        cost, at = heapq.heappop(heap)
        if cost > costs[at]:
            continue
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            to = at[0] + dx, at[1] + dy
            if not (0 <= to[0] < len(grid) and 0 <= to[1] < len(grid) and free[to]):
                continue
            more = cost + math.hypot(dx, dy)
            if more < costs.get(to, math.inf):
                costs[to], before[to] = more, at
                heapq.heappush(heap, (more, to))
    goal = max(costs, key=lambda cell: costs[cell] if costs[cell] < 45.0 else 0.0)
    if costs[goal] * _CELL_M < _FAR_M:
        return ()
    cells = [goal]
    while before[cells[-1]] != cells[-1]:
        cells.append(before[cells[-1]])
    way = [(grid[i], grid[j]) for i, j in reversed(cells)]
    step = round(_AHEAD_M / _CELL_M)
    kept = [*way[step:-step:step], way[-1]]
    return tuple((float(x), float(y)) for x, y in kept)


def _cell(point: Point) -> tuple[int, int]:
    i, j = (round((one + _HALF_M) / _CELL_M) for one in point)
    return i, j


def _distances(points: FloatArray, segments: FloatArray) -> FloatArray:
    """(N,): distance of each point to the nearest segment."""
    nearest = np.full(len(points), np.inf)
    for ax, ay, bx, by in segments:
        ex, ey = bx - ax, by - ay
        x, y = points[:, 0] - ax, points[:, 1] - ay
        share = np.clip((x * ex + y * ey) / max(1e-12, ex * ex + ey * ey), 0.0, 1.0)
        nearest = np.minimum(nearest, np.hypot(x - share * ex, y - share * ey))
    return nearest
