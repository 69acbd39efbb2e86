"""What steps of a world work with, besides what it is: made for its bodies, and kept until there are others."""

from __future__ import annotations

import numpy as np

from softbody.bodies.store import Store
from softbody.collision.boxes.manifold import new_manifold
from softbody.collision.pressed import never_pressed
from softbody.collision.soft.skin import Skin, build_skin, forget, with_room_for_pairs
from softbody.collision.soft.soft_response import parting_times
from softbody.collision.soft.surface import Surfaces, build_surfaces
from softbody.compiler.interrupts import NEVER_SET, InterruptFlag
from softbody.compiler.threads import Team
from softbody.dynamics.acting import Acting, memory_for_forces
from softbody.dynamics.liquid_rates import feels_liquid
from softbody.dynamics.soft_bodies import Motion, motion_of
from softbody.dynamics.stability import most_extents
from softbody.model.arrays import Joints, Model, State
from softbody.stepping.checks import check_may_tear, may_carry_too_much
from softbody.stepping.skins import Skins
from softbody.stepping.step import Work
from softbody.stepping.tears import Tearing, tearing_of


class Memory:
    """The memory of steps on so many `threads`, for the bodies that are in a store now."""

    def __init__(self, store: Store, threads: int) -> None:
        self.contents = store.contents  # that it was made for
        self.threads = threads
        self.team = Team(threads)
        self._store = store
        self._motion: Motion | None = None
        self._surfaces: Surfaces | None = None
        self._manifold = new_manifold()
        self.pressed = never_pressed()
        self.told = set[tuple[int, int]]()  # pairs of bodies that were said to be pressed
        self.started_inside = set[tuple[int, int]]()
        self.said_out = set[int]()  # boxes that were said to be outside of what they are to be inside
        self._skins: Skins | None = None
        self._skin: Skin | None = None
        self._start: State | None = None  # memory for that of a step
        self._grounded: np.ndarray | None = None  # memory for which boxes touch the ground
        self._acting: Acting | None = None  # memory for what acts in a step with joints or liquids
        self._tearing: Tearing | None = None
        self._tearing_of: Model | None = None
        self._limits_of: tuple[Model | None, bytes] = None, b""  # for which springs and gas extents are limited
        self._times_of: tuple[Model | None, bytes] = None, b""  # for which springs and gas parting times are known
        self._unlike_of: tuple[Model | None, bool] = None, False  # of which masses, and whether any are too unlike
        rest = store.contents.sleep.rest
        rest.settled[:] = False  # bounds of those who sleep are not known here

    def work(self, flag: InterruptFlag) -> Work:
        """Return what a step needs, with nothing for a kind of bodies that there is none of."""
        store, has_boxes = self._store, self._store.model.box_count > 0
        motion = self.motion(flag) if store.model.soft_count else None
        joints, acting = self.acting()
        if self._start is None:
            self._start = store.state.copy()
            self._grounded = np.zeros(store.model.box_count, bool) if has_boxes else None
        return Work(
            motion,
            self.surfaces(),
            self.skin(),
            self._manifold if has_boxes else None,
            self._start,
            self._grounded,
            self.contents.ground_impulse,
            joints,
            acting,
            self.contents.sleep.rest if store.may_sleep else None,
            flag.is_set,
            self.pressed,
            self.tearing(),
        )

    def tearing(self) -> Tearing:
        """Return what may tear, and the holes that there are."""
        model = self._store.model
        if self._tearing is None or self._tearing_of is not model:
            check_may_tear(model, self._store.joints, self._store.names)
            self._tearing, self._tearing_of = tearing_of(model, self._store.rings), model
        return self._tearing

    def remember(self, before: Memory) -> None:
        """Remember what was said, before there were more soft bodies, about those that there were."""
        old, more = before.contents.parts.model.soft_count, self._store.model.soft_count

        def now(pair: tuple[int, int]) -> tuple[int, int]:
            a, b = (number + (more - old if number >= old else 0) for number in pair)
            return a, b

        self.told, self.started_inside = set(map(now, before.told)), set(map(now, before.started_inside))
        self.said_out = before.said_out

    def acting(self) -> tuple[Joints, Acting] | tuple[None, None]:
        """Return the joints, and memory for what acts in a step, where there are joints or liquids."""
        store = self._store
        if self._acting is None and (len(store.joints.joint_box) or feels_liquid(store.model)):
            self._acting = memory_for_forces(store.state, store.controls, store.rings)
        return (None, None) if self._acting is None else (store.joints, self._acting)

    def motion(self, flag: InterruptFlag) -> Motion:
        """Return what moves soft bodies."""
        store, model = self._store, self._store.model
        motion, is_watched = self._motion, model.soft_count == 1 and model.soft_self_contact[0] > 0.0
        if motion is None or (is_watched and not len(motion.watch.seen)):
            watched = model.triangle_particles if is_watched else None
            motion = motion_of(model.soft_particle_start, store.rings, self.threads, watched)
            if store.may_sleep:
                asleep = self.contents.sleep.rest.asleep[: model.soft_count]
                motion = motion._replace(memory=motion.memory._replace(asleep=asleep))
            self._limits_of = None, b""
        motion = self._motion = motion._replace(rings=store.rings)
        if motion.watch.square is not self.tearing().limits.square:
            motion = self._motion = motion._replace(watch=motion.watch._replace(**self.tearing().limits._asdict()))
        gas = store.controls.soft_gas.tobytes()
        if not (self._limits_of[0] is model and self._limits_of[1] == gas):
            motion.memory.most_extent[:] = most_extents(model, store.controls)
            self._limits_of = model, gas
        if flag is NEVER_SET:
            return motion
        return motion._replace(memory=motion.memory._replace(stop=flag.is_set))

    def surfaces(self) -> Surfaces | None:
        """Return what finds the contacts of soft bodies, if there are any."""
        model, controls = self._store.model, self._store.controls
        if self._surfaces is None and model.soft_count:
            self._surfaces = build_surfaces(model, self._store.state.particle_position, self.threads)
            response = self._surfaces.response
            response.edge_length[:] = model.soft_edge_length
            response.thickness[:] = np.append(model.soft_thickness, model.box_size.min(axis=1, initial=np.inf))
            self._surfaces = self._surfaces._replace(response=response._replace(pressed=self.pressed))
        gas = controls.soft_gas.tobytes()
        if self._surfaces is not None and not (self._times_of[0] is model and self._times_of[1] == gas):
            self._surfaces.response.parting_time[:] = parting_times(model, controls)
            self._times_of = model, gas
        return self._surfaces

    def skin(self) -> Skin | None:
        """Return what soft bodies that hold themselves are known by, if any does just now."""
        model = self._store.model
        if not (model.soft_self_contact > 0.0).any():
            return None
        if self._skin is None:
            self._skin = build_skin(model, self._store.state.particle_position, self.motion(NEVER_SET).watch.seen)
        self._skin.distance[:] = np.maximum(model.soft_self_contact, 0.0)
        return self._skin

    def forget_skin(self) -> None:
        """Forget where the particles of bodies that hold themselves are."""
        if self._skin is not None:
            forget(self._skin)

    def make_room_for_pairs(self) -> None:
        """Make room for as many near features as there are."""
        assert self._skin is not None
        self._skin = with_room_for_pairs(self._skin)

    def skins(self) -> Skins:
        """Return what looks at soft bodies that may go through themselves."""
        if self._skins is None:
            self._skins = Skins(self._store.model)
        return self._skins

    def may_carry_too_much(self, model: Model) -> bool:
        """Tell what `checks.may_carry_too_much` says of a model, which is asked once."""
        if self._unlike_of[0] is not model:
            self._unlike_of = model, may_carry_too_much(model)
        return self._unlike_of[1]
