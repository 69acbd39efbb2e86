"""A box falls on a soft ring: the motion is kept, read as numbers, and exported. Writes fall/, fall.glb, last.ply."""

import numpy as np

import softbody

world = softbody.World()
world.add_ground()
world.add_soft_body(softbody.torus(0.8, 0.3, 32, 16), mass=1.0, stiffness=300.0, gas=40.0, position=(0.0, 0.0, 0.3))
world.add_box((1.0, 1.0, 0.3), mass=0.5, position=(0.0, 0.1, 1.2))
with softbody.TrajectoryWriter(world, "fall", frames_per_second=30) as kept:
    kept.run(seconds=1.5)

fall = softbody.Trajectory.open("fall")  # another day, in another program; also while it is being written
heights = np.array([frame.box_positions[0, 2] for frame in fall])
thickness = np.array([np.ptp(frame.positions[fall.particles(0), 2]) for frame in fall])
lowest = int(heights.argmin())
print(f"{fall}\nthe box is lowest, {heights[lowest]:.2f} m, after {fall.times[lowest]:.2f} s")
print(f"the ring is {thickness[lowest]:.2f} m thick then, {thickness[0]:.2f} m at first")

fall.export("fall.glb")  # moves, in Blender or a browser; fall.export("meshes", "ply") is a file for each frame
world.export("last.ply")
fall.put_into(world, lowest)  # to be pictured or measured as it was
print(f"its springs are strained by {world.soft_bodies[0].strain.max():.0%} at most")
