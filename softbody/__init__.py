"""Pressure soft bodies and rigid boxes in Numba, every piece held by claims that can fail.

Conventions, everywhere: SI units; z is up; right-handed axes; triangles counter-clockwise seen from outside; double
precision, but where single is asked for; quaternions (w, x, y, z), body frame to world frame; a normal of a contact of
a and b points from b to a; "§" is a section of the 2008 paper that the method comes from. Same inputs, same version,
same machine: same bits.
"""

from typing import TYPE_CHECKING, Any

from softbody.bodies.body import Body
from softbody.bodies.contact_points import ContactPoints
from softbody.bodies.ground import Ground
from softbody.bodies.joint import Joint
from softbody.bodies.liquid import Liquid
from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import Event, SoftBody
from softbody.bodies.strict_names import hint
from softbody.bodies.suspended import Suspended
from softbody.dynamics.energy import Energies
from softbody.errors import (
    BusyError,
    CacheWarning,
    InflationWarning,
    MassRatioWarning,
    MeshError,
    MissingPackageError,
    OutputError,
    OverlapWarning,
    OverloadWarning,
    ParameterError,
    SceneError,
    SelfIntersectionWarning,
    SimulationError,
    SnapshotError,
    SoftbodyError,
    TrajectoryError,
    ViewError,
)
from softbody.mesh.diagnostics import Finding
from softbody.mesh.mesh import Mesh, box, icosahedron, icosphere, octahedron, tetrahedron, torus
from softbody.model.arrays import Controls, Model, State
from softbody.trajectory import Bodies, Frame, Trajectory, TrajectoryWriter
from softbody.version import __version__ as __version__
from softbody.world import World

from softbody import scenes  # isort: skip (it needs all of the above)

if TYPE_CHECKING:
    from softbody.render import Camera, Recorder

__all__ = [
    "Bodies",
    "Body",
    "Box",
    "BusyError",
    "CacheWarning",
    "Camera",
    "ContactPoints",
    "Controls",
    "Energies",
    "Event",
    "Finding",
    "Frame",
    "Ground",
    "InflationWarning",
    "Joint",
    "Liquid",
    "MassRatioWarning",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "Model",
    "OutputError",
    "OverlapWarning",
    "OverloadWarning",
    "ParameterError",
    "Recorder",
    "SceneError",
    "SelfIntersectionWarning",
    "SimulationError",
    "SnapshotError",
    "SoftBody",
    "SoftbodyError",
    "State",
    "Suspended",
    "Trajectory",
    "TrajectoryError",
    "TrajectoryWriter",
    "ViewError",
    "World",
    "box",
    "icosahedron",
    "icosphere",
    "octahedron",
    "scenes",
    "tetrahedron",
    "torus",
]


def __dir__() -> list[str]:
    """Return what is public."""
    return [*__all__, "__version__"]


if not TYPE_CHECKING:  # which is to see names that there are none of

    def __getattr__(name: str) -> Any:
        """Return what makes pictures: it is imported when it is first asked for."""
        if name in ("Camera", "Recorder"):
            from softbody import render

            return getattr(render, name)
        meant = hint(name, __all__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{'; ' if meant else ''}{meant.strip()}")
