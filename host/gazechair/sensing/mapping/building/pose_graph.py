"""Pose graph: the poses that agree best with all measurements between them.

g2o (Kuemmerle et al., 2011) by the package g2opy of the extra `home`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray

_ITERATIONS = 15
# Standard deviations beyond which a loop's force stops growing: a wrong loop must not bend the map.
_HUBER = 2.0


class MissingPackageError(Exception):
    """Raised without g2opy; the text says what to install."""


@dataclass(frozen=True)
class Edge:
    """A measurement: the pose `second` as seen from the pose `first`."""

    first: int
    second: int
    seen: FloatArray
    """(3,): x, y in metres, heading in radians."""
    information: FloatArray
    """(3, 3): inverse of its covariance, in the frame of `first`."""
    loop: bool = False


def optimized(poses: Sequence[FloatArray], edges: Sequence[Edge]) -> list[FloatArray]:
    """The poses moved so that the edges fit; the first one stays. Raises MissingPackageError."""
    try:
        import g2opy
    except ImportError:
        raise MissingPackageError("maps are made with g2opy: pip install gazechair[home]") from None
    optimizer = g2opy.SparseOptimizer()
    solver = g2opy.BlockSolverSE2(g2opy.LinearSolverEigenSE2())
    optimizer.set_algorithm(g2opy.OptimizationAlgorithmLevenberg(solver))
    for number, pose in enumerate(poses):
        vertex = g2opy.VertexSE2()
        vertex.set_id(number)
        vertex.set_estimate(g2opy.SE2(*map(float, pose)))
        vertex.set_fixed(number == 0)
        optimizer.add_vertex(vertex)
    for edge in edges:
        link = g2opy.EdgeSE2()
        link.set_vertex(0, optimizer.vertex(edge.first))
        link.set_vertex(1, optimizer.vertex(edge.second))
        link.set_measurement(g2opy.SE2(*map(float, edge.seen)))
        link.set_information(np.asarray(edge.information, dtype=np.float64))
        if edge.loop:
            link.set_robust_kernel(g2opy.RobustKernelHuber(_HUBER))
        optimizer.add_edge(link)
    optimizer.initialize_optimization()
    optimizer.optimize(_ITERATIONS)
    return [
        np.array(optimizer.vertex(number).estimate().to_vector()) for number in range(len(poses))
    ]
