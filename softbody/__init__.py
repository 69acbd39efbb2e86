"""Pressure soft bodies and rigid boxes in Numba, every piece held by claims that can fail.

Conventions, everywhere: SI units; z is up; right-handed axes; triangles counter-clockwise seen from outside; double
precision, but where single is asked for; quaternions (w, x, y, z), body frame to world frame; a normal of a contact of
a and b points from b to a; "§" is a section of the 2008 paper that the method comes from. Same inputs, same version,
same machine: same bits.
"""

from softbody.bodies import Body
from softbody.contact_points import ContactPoints
from softbody.dynamics.energy import Energies
from softbody.errors import (
    BusyError,
    CacheWarning,
    MassRatioWarning,
    MeshError,
    MissingPackageError,
    OverlapWarning,
    ParameterError,
    SimulationError,
    SnapshotError,
    SoftbodyError,
)
from softbody.mesh import Mesh, box, icosahedron, icosphere, octahedron, tetrahedron, torus
from softbody.mesh_findings import Finding
from softbody.rigid_box import Box
from softbody.soft_body import SoftBody
from softbody.state import Controls, Model, State
from softbody.world import World

from softbody import scenes  # isort: skip (it needs all of the above)

__version__ = "0.1.0"

__all__ = [
    "Body",
    "Box",
    "BusyError",
    "CacheWarning",
    "ContactPoints",
    "Controls",
    "Energies",
    "Finding",
    "MassRatioWarning",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "Model",
    "OverlapWarning",
    "ParameterError",
    "SimulationError",
    "SnapshotError",
    "SoftBody",
    "SoftbodyError",
    "State",
    "World",
    "box",
    "icosahedron",
    "icosphere",
    "octahedron",
    "scenes",
    "tetrahedron",
    "torus",
]
