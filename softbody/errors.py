"""What the core raises: every message names the culprit and the cure."""

from __future__ import annotations

import inspect
import warnings


class SoftbodyError(Exception):
    """Any error that the core raises on purpose."""


class MeshError(SoftbodyError, ValueError):
    """A mesh that is not a closed, consistently oriented surface with a positive volume."""


class ParameterError(SoftbodyError, ValueError):
    """A physical parameter outside its range."""


class SnapshotError(ParameterError):
    """A snapshot, or a saved world, that is damaged, of another version, or none: which entry, and what it must be."""


class TrajectoryError(ParameterError):
    """A trajectory that is damaged, of another version, of other bodies, or none: which entry, and the cure."""


class SceneError(ParameterError):
    """A scene file that cannot be used: everything that is wrong in it, each with its line and its cure."""


class MissingPackageError(SoftbodyError, ImportError):
    """Something was asked for that takes a package which is not installed: which one, and how to install it."""


class BusyError(SoftbodyError, RuntimeError):
    """A world that is being stepped, by another thread or further up in this one, was asked for something else."""


class OutputError(SoftbodyError, OSError):
    """A picture, film, trajectory or mesh file that cannot be written: which, why, and what is kept all the same."""


class ViewError(SoftbodyError, OSError):
    """A live view that cannot be opened, because its port is taken for one."""


class OverlapWarning(UserWarning):
    """Bodies that start inside each other: they are pushed apart, from deep inside not all the way."""


class OverloadWarning(UserWarning):
    """Bodies that are pressed deep into each other, by more than their contact holds at this step."""


class SelfIntersectionWarning(UserWarning):
    """A soft body that goes through itself, as nothing keeps it from that; or not yet, if it is to hold itself."""


class InflationWarning(UserWarning):
    """A soft body whose gas is going to stretch it far, such as one in joule for a part of centimetres."""


class CacheWarning(UserWarning):
    """Machine code that cannot be kept on disk: kernels are compiled anew in every process."""


class MassRatioWarning(UserWarning):
    """A box that carries a body so much heavier than itself that it may be pressed through what it stands on."""


class SimulationError(SoftbodyError, RuntimeError):
    """A simulation that diverged or a body that collapsed; the state is the last good one.

    Attributes: `step` (steps done since the world was made), `body` (its kind and index, such as "soft body 0")
    and `stable_time_step` [s], an estimate for the last good state; 0 where no time step helps.
    """

    def __init__(self, message: str, step: int, body: str, stable_time_step: float) -> None:
        super().__init__(message)
        self.step = step
        self.body = body
        self.stable_time_step = stable_time_step

    def __reduce__(self) -> tuple[type, tuple[str, int, str, float]]:
        """Pickle with all four arguments: by default only the message is kept, and a process pool would hang."""
        return type(self), (str(self), self.step, self.body, self.stable_time_step)


def warn_user(message: str, category: type[Warning]) -> None:
    """Warn at the line that has called the core."""
    level, frame = 1, inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)
