"""The numbers that users may give each body, as `softbody.model.arrays.Model` declares them."""

from __future__ import annotations

from functools import cache
from typing import Any, get_type_hints

import numpy as np

from softbody.errors import ParameterError
from softbody.model.arrays import Model, Property
from softbody.model.settings import Settings, check_holds_itself
from softbody.model.validation import check_range


def properties_of(kind: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return the Properties of a new body of a `kind`, "soft" or "box": those `given`, and the others' defaults.

    Keys are fields of a Model. One of None is left to `builder.with_soft_body`. Raises ParameterError for a number out
    of its range.
    """
    values = dict[str, Any]()
    for field, note in known_properties().items():
        if field.startswith(f"{kind}_"):
            value: Any = given.get(field.removeprefix(f"{kind}_"), note.default)
            if note.is_chosen and isinstance(value, (bool, np.bool_)):
                values[field] = None if value else 0.0
            else:
                values[field] = None if value is note.default is None else checked_property(field, value)
    return values


def checked_property(field: str, value: float) -> float:
    """Return a Property of a Model, checked; raises ParameterError for a number out of its range."""
    note = known_properties()[field]
    return check_range(value, field.split("_", 1)[1], note.unit, least=note.least, most=note.most)


def check_self_contact(settings: Settings, distance: float | None) -> None:
    """Raise ParameterError unless bodies may keep a `distance` [m] from themselves, with these settings; None: any."""
    if distance is not None and distance < 0.0:
        raise ParameterError(f"self_contact is {distance}; give True, False, or a distance ≥ 0 [m]")
    check_holds_itself(settings, distance != 0.0)


@cache
def known_properties() -> dict[str, Property]:
    """Return the fields of a Model that are Properties."""
    hints = get_type_hints(Model, include_extras=True)
    notes = {field: getattr(hint, "__metadata__", (None,))[0] for field, hint in hints.items()}
    return {field: note for field, note in notes.items() if isinstance(note, Property)}
