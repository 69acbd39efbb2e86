"""What a world did, kept: a TrajectoryWriter grows a folder by a frame at a time, and a Trajectory reads it.

The folder holds `bodies.npz`, what does not change; `000000.npz` and so on, chunks of frames; and `trajectory.json`,
the manifest, which says what of these counts. Where bodies are added or removed, or change their meshes, a segment of
frames ends, and another begins: with bodies of its own, `bodies-000001.npz` and so on, and chunks of its own. Each file
is written whole, the manifest last: so at any moment, and after a kill, the folder is a trajectory. What is read may
come from anywhere: nothing in it is believed.

A chunk of f frames has `time` (f,) [s], and of the fields of a State, with an axis of frames before their own,
`particle_position`, `box_position`, `box_orientation`, and, if they are kept, `particle_velocity`, `box_velocity` and
`box_angular_velocity`. `bodies.npz` has the fields of Shapes.
"""

from softbody.trajectory.bodies import Bodies
from softbody.trajectory.reader import Frame, Trajectory
from softbody.trajectory.writer import TrajectoryWriter

__all__ = ["Bodies", "Frame", "Trajectory", "TrajectoryWriter"]
