"""Two jaws close on a soft ball and lift it; friction holds it. Writes gripper.webp."""

import softbody

world = softbody.World()
world.add_ground(friction=0.6)
ball = world.add_soft_body(
    softbody.icosphere(2, 0.1), mass=0.2, stiffness=150.0, pressure=2000.0, position=(0.0, 0.0, 0.1), friction=1.0
)
jaws = [
    world.add_box((0.04, 0.16, 0.12), None, (side * 0.16, 0.0, 0.11), friction=1.0, name=f"jaw {side}")
    for side in (-1, 1)
]
camera = softbody.Camera((1.0, -1.5, 0.9), (0.0, 0.0, 0.35))
with softbody.Recorder(world, "gripper.webp", frames_per_second=20, camera=camera) as film:
    for reach, height, seconds in ((0.09, 0.11, 1.0), (0.09, 0.6, 2.0), (0.09, 0.6, 0.5)):  # close, lift, hold
        for jaw, side in zip(jaws, (-1, 1)):
            jaw.move_to((side * reach, 0.0, height), seconds=seconds)
        film.run(seconds)
grip = abs(world.contact_points().force_on(jaws[0])[0])
print(f"the ball hangs at {ball.centre[2]:.2f} m, between jaws that press with {grip:.1f} N")
