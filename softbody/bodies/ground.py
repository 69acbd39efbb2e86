"""The ground of a World: a handle, for what of it may be set between steps."""

from __future__ import annotations

from softbody.bodies.surroundings import Number, Surroundings


class Ground(Surroundings):
    """The ground of a World: everything below a height is solid, if `World.add_ground` was called."""

    __slots__ = ()

    kind = "ground"

    height = Number("Height z [m] below which all is solid.", "m")
    restitution = Number("Restitution in contacts, 0 … 1.", least=0.0, most=1.0)
    friction = Number("Coulomb coefficient of friction in contacts, ≥ 0.", least=0.0)

    @property
    def is_there(self) -> bool:
        """Whether there is a ground."""
        return self.store.model.ground_height > -float("inf")

    def __repr__(self) -> str:
        """Say how high it is, and what meets on it."""
        if not self.is_there:
            return "<no ground>"
        return f"<ground at {self.height:.4g} m: restitution {self.restitution:.4g}, friction {self.friction:.4g}>"
