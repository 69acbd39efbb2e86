"""Drake's boxes: discrete multibody plants whose contacts are patches of pressure between soft and hard boxes."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from pydrake.all import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddMultibodyPlantSceneGraph,
    Box,
    ContactModel,
    CoulombFriction,
    DiagramBuilder,
    DiscreteContactApproximation,
    MultibodyPlant,
    ProximityProperties,
    Quaternion,
    RigidTransform,
    Simulator,
    SpatialInertia,
    SpatialVelocity,
)

sys.path.insert(0, str(Path(__file__).parents[1]))
from protocol import serve, spending

HEAVY = 1e6  # [kg], of a held box that moves


def move_boxes(
    step: float,
    steps: float,
    every: float,
    gravity: float,
    friction: float,
    restitution: float,
    modulus: float,
    size: np.ndarray,
    mass: np.ndarray,
    position: np.ndarray,
    orientation: np.ndarray,
    velocity: np.ndarray,
    spin: np.ndarray,
) -> dict[str, np.ndarray]:
    """Let boxes move."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, MultibodyPlant(step))
    plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -gravity])
    bodies, poses, still = [], [], []
    for k in range(len(size)):
        held = not np.isfinite(mass[k])
        moves = bool(velocity[k].any() or spin[k].any())
        instance = plant.AddModelInstance(f"box {k}")
        kilogram = HEAVY if held else float(mass[k])
        body = plant.AddRigidBody(f"box {k}", instance, SpatialInertia.SolidBoxWithMass(kilogram, *size[k]))
        properties = ProximityProperties()
        AddContactMaterial(1.0 - restitution, None, CoulombFriction(friction, friction), properties)
        AddCompliantHydroelasticProperties(float(size[k].min()), modulus, properties)
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(*size[k]), f"box {k}", properties)
        pose = RigidTransform(Quaternion(orientation[k] / np.linalg.norm(orientation[k])), position[k])
        if held and not moves:
            plant.WeldFrames(plant.world_frame(), body.body_frame(), pose)
        elif held:
            plant.set_gravity_enabled(instance, False)
        bodies.append(body)
        poses.append(pose)
        still.append(held and not moves)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for k, body in enumerate(bodies):
        if not still[k]:
            plant.SetFreeBodyPose(context, body, poses[k])
            plant.SetFreeBodySpatialVelocity(context, body, SpatialVelocity(spin[k], velocity[k]))
    simulator.Initialize()
    frames = []
    with spending():
        for frame in range(int(steps) // int(every)):
            simulator.AdvanceTo((frame + 1) * int(every) * step)
            at = [plant.EvalBodyPoseInWorld(context, body) for body in bodies]
            speed = [plant.EvalBodySpatialVelocityInWorld(context, body) for body in bodies]
            frames.append(
                (
                    [pose.translation() for pose in at],
                    [pose.rotation().ToQuaternion().wxyz() for pose in at],
                    [one.translational() for one in speed],
                    [one.rotational() for one in speed],
                )
            )
    told = [np.array(rows, float).reshape(len(frames), len(bodies), -1) for rows in zip(*frames)]
    return dict(zip(("position", "orientation", "velocity", "spin"), told))


serve({"move_boxes": move_boxes})
