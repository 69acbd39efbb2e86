"""A learning environment, with the interface of Gymnasium: push a soft ball to a mark by a force along the ground."""

import numpy as np

import softbody


class PushBall:
    """Seen are the way to the mark [m] and the ball's speed [m/s]; an action, −1 to 1, is a force of so many 5 N."""

    def __init__(self, mark=1.0):
        self.world, self.mark, shape = softbody.World(), mark, softbody.icosphere(1, 0.2)
        self.world.add_ground(friction=0.8)
        self.ball = self.world.add_soft_body(shape, mass=0.5, stiffness=200.0, pressure=300.0, position=(0.0, 0.0, 0.2))
        self.start = self.world.state.particle_position.copy()

    def reset(self, seed=None, options=None):
        """Put the ball somewhere, at rest; return what is seen, and a dictionary."""
        self.ball.positions = self.start + [np.random.default_rng(seed).uniform(-0.5, 0.5), 0.0, 0.0]
        self.ball.velocities = np.zeros_like(self.start)
        return self._seen(), {}

    def step(self, action):
        """Push for a frame; return what is seen, the reward, whether it is done or cut short, and a dictionary."""
        self.ball.external_force = (5.0 * np.clip(action, -1.0, 1.0) / len(self.start), 0.0, 0.0)
        self.world.step_frame(1 / 60)
        seen = self._seen()
        return seen, -abs(seen[0]), bool(abs(seen[0]) < 0.02 and abs(seen[1]) < 0.05), False, {}

    def _seen(self):
        return np.array([self.mark - self.ball.centre[0], self.ball.velocity[0]])


environment = PushBall()
for episode in range(3):
    (way, speed), _ = environment.reset(seed=episode)
    done, frames = False, 0
    while not done and (frames := frames + 1) < 600:
        (way, speed), reward, done, _, _ = environment.step(0.5 * way - 0.5 * speed)
    print(f"episode {episode}: {abs(way) * 1e3:.0f} mm from the mark after {frames} frames")
