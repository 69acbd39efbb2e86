"""Drake's boxes, by way of a Python of its own (double precision)."""

from __future__ import annotations

from validation.foreign import engine
from validation.subject import Boxes, Motion

SETTINGS = {  # what was chosen against the defaults, and why
    "hydroelastic contact, all boxes compliant with 1e6 Pa": (
        "by points (the default where nothing else is said) two faces have one contact. Harder boxes are carried and"
        " slide worse at these steps, softer ones sink"
    ),
    "discrete approximation Lagged (SAP too is at hand)": "it knows dissipation by Hunt and Crossley",
    "dissipation 1 − e [s/m]": "it has no restitution, and this is what gives back e of 1 m/s",
    "a held box that moves weighs 1e6 kg, without gravity": "welded boxes have no speed",
}
CANNOT = {  # question → why it has no answer
    "boxes_overlap": "its adapter does not ask it so far",
    "gas_volume": "its soft bodies are elastic throughout, and have no gas",
    "gas_period": "its soft bodies are elastic throughout, and have no gas",
    "points_in_mesh": "its adapter does not ask it so far",
    "move_soft": "its soft bodies are elastic throughout, and have no gas",
}

MODULUS = 1e6  # [Pa]


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    rows = boxes._asdict()
    numbers = {name: float(rows.pop(name)) for name in ("gravity", "friction", "restitution")}
    numbers |= {"step": step, "steps": steps, "every": every, "modulus": MODULUS}
    return Motion(**engine("drake").ask("move_boxes", numbers, **rows))
