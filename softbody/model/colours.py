"""Colours of bodies wherever they are seen: in pictures, in the browser, in files."""

Colour = tuple[float, float, float]  # red, green and blue, 0 … 1, as screens are told

OF_BODIES: list[Colour] = [  # in turn; boxes come after soft bodies
    (0.86, 0.44, 0.24),
    (0.24, 0.50, 0.80),
    (0.38, 0.64, 0.36),
    (0.75, 0.60, 0.22),
    (0.58, 0.40, 0.70),
]
STATIC: Colour = (0.70, 0.72, 0.75)  # of boxes that cannot move, and of all where colours show what boxes have none of


def colour_of(number: int) -> Colour:
    """Return the colour of a body, by its number among all, boxes after soft bodies."""
    return OF_BODIES[number % len(OF_BODIES)]
