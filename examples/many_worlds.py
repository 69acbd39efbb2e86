"""How far does a ball bounce back, by its stiffness? Eight worlds in processes of their own."""

from concurrent.futures import ProcessPoolExecutor

import softbody


def rebound(stiffness: float) -> float:
    """Return how high [m] the lowest point comes after the first bounce, from 1 m."""
    world = softbody.World()
    world.add_ground()
    ball = world.add_soft_body(
        softbody.icosphere(2, radius=0.5), mass=1.0, stiffness=stiffness, gas=30.0, position=(0.0, 0.0, 1.5)
    )
    heights = [ball.positions[:, 2].min() for _ in world.frames(seconds=1.5)]
    return float(max(heights[heights.index(0.0) :]))


if __name__ == "__main__":
    stiffnesses = [50.0 * 2.0**k for k in range(8)]
    with ProcessPoolExecutor(2) as pool:
        for stiffness, height in zip(stiffnesses, pool.map(rebound, stiffnesses), strict=True):
            print(f"{stiffness:6.0f} N/m: {height:.2f} m")
