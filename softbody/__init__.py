"""Pressure soft bodies and rigid boxes in Numba, every piece checked against independent reference engines.

Conventions, everywhere: SI units; z is up; right-handed axes; triangles counter-clockwise seen from outside;
float64; quaternions (w, x, y, z), body frame to world frame; a normal of a contact of a and b points from b to a;
"§" is a section of the 2008 paper that the method comes from. Same inputs, same version, same machine: same bits.
"""

from softbody.errors import MeshError, OverlapWarning, ParameterError, SimulationError, SoftbodyError
from softbody.mesh import Mesh, box, icosahedron, icosphere, octahedron, tetrahedron, torus
from softbody.state import Model, State
from softbody.world import Box, SoftBody, World

__version__ = "0.1.0"

__all__ = [
    "Box",
    "Mesh",
    "MeshError",
    "Model",
    "OverlapWarning",
    "ParameterError",
    "SimulationError",
    "SoftBody",
    "SoftbodyError",
    "State",
    "World",
    "box",
    "icosahedron",
    "icosphere",
    "octahedron",
    "tetrahedron",
    "torus",
]
