"""A soft ball is bowled into a tower of boxes: which of them fall? Writes bowling.webp."""

import softbody

world = softbody.World()
world.add_ground(friction=0.8)
boxes = []
for row in range(4):
    for k in range(4 - row):
        place = (0.0, 0.5 * (k - 0.5 * (3 - row)), 0.2 + 0.4 * row)
        boxes.append(world.add_box((0.4, 0.4, 0.4), mass=0.2, position=place))
start, speed = (-2.5, 0.0, 0.5), (7.0, 0.0, 0.0)
ball = world.add_soft_body(softbody.icosphere(3, radius=0.5), 2.0, 600.0, 60.0, start, speed, friction=0.8, damping=0.3)

camera = softbody.Camera(eye=(-4.0, -5.0, 2.5), target=(0.5, 0.0, 0.6))
with softbody.Recorder(world, "bowling.webp", frames_per_second=25, camera=camera, size=(480, 320)) as film:
    film.run(seconds=2.0)
moved = sum(abs(box.position[0]) > 0.2 for box in boxes)
print(f"{moved} of {len(boxes)} boxes were moved by more than half their size")
