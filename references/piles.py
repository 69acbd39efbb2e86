"""Final places and speeds of piled boxes, by Bullet, MuJoCo and Rapier as their users have them.

Defaults are kept: MuJoCo's soft contacts (`solref`, `solimp`, pyramidal cones, Newton's method, 100 iterations) and
Rapier's (4 iterations). Bullet: see `pybullet_world`. The ground is a box, or a plane.
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import rapier3d

from references.pybullet_world import BulletWorld

PACKAGES = {"mujoco": "mujoco", "pybullet": "pybullet", "rapier3d": "rapier3d"}  # import name, and the name to install
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "nobody sleeps": "a pile that sleeps does not say whether it rests",
    "the same friction on both bodies of a pair": "MuJoCo takes the larger of two, Rapier the mean",
}

Boxes = list[tuple[np.ndarray, ...]]  # full size [m], place [m], orientation; 1 kg a m³
Ended = tuple[np.ndarray, np.ndarray]  # places [m] and velocities [m/s], (m, 3)


def by_bullet(boxes: Boxes, friction: float, step: float, steps: int) -> Ended:
    """Let boxes fall for so many steps of `step` [s]; 50 iterations, Bullet's default."""
    world = BulletWorld(step, 50, friction=friction, residual=1e-7)
    world.add_ground()
    for size, place, orientation in boxes:
        world.add_box(size, float(np.prod(size)), place, orientation)
    world.step(steps)
    ended = world.positions(), world.velocities()[:, :3]
    world.close()
    return ended


def by_mujoco(boxes: Boxes, friction: float, step: float, steps: int) -> Ended:
    """Let boxes fall for so many steps of `step` [s]."""
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    rub = [friction, 0.005, 1e-4]
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[200.0, 200.0, 1.0], friction=rub)
    for size, place, orientation in boxes:
        body = spec.worldbody.add_body(pos=place, quat=orientation)
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=0.5 * size, mass=float(np.prod(size)), friction=rub)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, steps)
    return data.qpos.reshape(-1, 7)[:, :3].copy(), data.qvel.reshape(-1, 6)[:, :3].copy()


def by_rapier(boxes: Boxes, friction: float, step: float, steps: int) -> Ended:
    """Let boxes fall for so many steps of `step` [s]."""
    world = rapier3d.PhysicsWorld(gravity=(0.0, 0.0, -9.81))
    world.set_num_threads(1)
    world.integration_parameters.dt = step
    world.add_collider(rapier3d.Collider.cuboid(200.0, 200.0, 1.0).translation((0.0, 0.0, -1.0)).friction(friction))
    handles = []
    for size, place, orientation in boxes:
        body = rapier3d.RigidBody.dynamic().position(rapier3d.Isometry3(place, rapier3d.Rotation3(*orientation)))
        shape = rapier3d.Collider.cuboid(*(0.5 * size)).mass(float(np.prod(size))).friction(friction)
        handles.append(world.add_body(body.can_sleep(False), [shape]))
    for _ in range(steps):
        world.step()
    ended = [world.rigid_bodies[handle] for handle in handles]
    return np.array([list(box.translation) for box in ended]), np.array([list(box.linvel) for box in ended])


ENGINES: dict[str, Callable[[Boxes, float, float, int], Ended]] = {
    "Bullet": by_bullet,
    "MuJoCo": by_mujoco,
    "Rapier": by_rapier,
}
