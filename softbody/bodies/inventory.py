"""What is in a world, to be looked at: handles by name and number, arrays, time, energies and momenta."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.energies import energies_of, energy_of
from softbody.bodies.ground import Ground
from softbody.bodies.joint import Joint
from softbody.bodies.liquid import Liquid, check_level
from softbody.bodies.rigid_box import Box, boxes_of
from softbody.bodies.soft_body import SoftBody, soft_bodies_of
from softbody.bodies.store import Store
from softbody.bodies.strict_names import StrictNames, check_options
from softbody.bodies.suspended import Suspended
from softbody.dynamics.energy import Energies, angular_momentum, linear_momentum
from softbody.model.arrays import Controls, Model, State
from softbody.model.validation import check_range, vector

if TYPE_CHECKING:
    from typing_extensions import Self


class Inventory(StrictNames):
    """What a `softbody.World` shows of what is in its store."""

    __slots__ = ("__weakref__", "store")

    store: Store

    def __new__(cls, *_: Any, **options: Any) -> Self:
        """Refuse options that are mistyped; raises ParameterError, which names those that there are."""
        check_options(f"a {cls.__name__}", cls.__init__, options)
        return super().__new__(cls)

    def __getitem__(self, name: str) -> SoftBody | Box | Joint | Suspended:
        """Return a handle of the body, or joint, that has a name; raises ParameterError, which lists those there are.

        It was given where it was added, `add_box(…, name="lid")`, or later, `box.name = "lid"`.
        """
        kind, index = self.store.names.who(name)
        kinds: dict[str, type[SoftBody | Box | Joint | Suspended]] = {"soft": SoftBody, "box": Box, "joint": Joint}
        return kinds.get(kind, Suspended)(self, index)

    def __contains__(self, name: object) -> bool:
        """Tell whether a body, or a joint, has this name."""
        return name in self.store.names

    @property
    def soft_bodies(self) -> tuple[SoftBody, ...]:
        """All soft bodies, as they were added."""
        return soft_bodies_of(self)

    @property
    def boxes(self) -> tuple[Box, ...]:
        """All boxes, as they were added."""
        return boxes_of(self)

    @property
    def joints(self) -> tuple[Joint, ...]:
        """All joints, as they were added."""
        return tuple(Joint(self, i) for i in range(len(self.store.joints.joint_box)))

    @property
    def suspended(self) -> tuple[Suspended, ...]:
        """All that hangs in soft bodies, as it was suspended."""
        return tuple(Suspended(self, i) for i in range(len(self.store.joints.suspension_box)))

    @property
    def ground(self) -> Ground:
        """The ground: its height, restitution and friction may be set between steps, once there is one."""
        return Ground(self)

    @property
    def liquid(self) -> Liquid:
        """The liquid: its density, surface height, drag and velocity may be set between steps, once there is one."""
        return Liquid(self)

    @property
    def gravity(self) -> np.ndarray:
        """Gravity (3,) [m/s²]; may be assigned between steps."""
        return self.controls.gravity

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        gravity = vector(value, "gravity")
        if self.liquid.is_there:
            check_level(gravity)
        self.store.controls.gravity[:] = gravity

    @property
    def model(self) -> Model:
        """What the bodies are."""
        return self.store.model

    @property
    def controls(self) -> Controls:
        """What acts on the bodies."""
        return self.store.controls

    @property
    def state(self) -> State:
        """Where the bodies are."""
        return self.store.state

    @property
    def steps(self) -> int:
        """Steps done since the world was made."""
        return self.store.steps

    @property
    def time(self) -> float:
        """Time since the world was made [s]; may be assigned, ≥ 0."""
        return self.store.time

    @time.setter
    def time(self, value: float) -> None:
        self.store.clock.time[0] = check_range(value, "time", "s", least=0.0)

    def energy(self) -> float:
        """Return kinetic + spring + gas + gravity + liquid energy [J] of all that can move, less the work of forces.

        The springs of joints count.

        That is, Σ f·x of the forces on particles; forces on boxes are not in it.
        """
        return energy_of(self.store)

    def energies(self) -> Energies:
        """Return the energy [J] of every body that can move, by kind: kinetic, spring, gas, gravity, external, liquid.

        Of gas it is what it gives when it expands from here to its mesh's volume as it was added (less than 0 if it is
        larger): −nRT ln(V / V0). Of liquids it is ρ g ∫ depth dV over what is submerged, and what it took to press
        together those in bodies, whose weight is in gravity. Only differences of those in gas, gravity and external
        forces mean something, and `total` is the sum.
        """
        return energies_of(self.store)

    def linear_momentum(self) -> np.ndarray:
        """Return Σ m v (3,) [kg m/s]."""
        return np.array(linear_momentum(self.model, self.state))

    def angular_momentum(self) -> np.ndarray:
        """Return Σ x × m v + Σ I ω (3,) [kg m²/s] about the origin."""
        return np.array(angular_momentum(self.model, self.state))
