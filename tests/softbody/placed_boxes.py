"""Boxes anywhere, turned anyhow, for tests of what they do to each other."""

import numpy as np
from hypothesis import strategies as st

from softbody.collision.boxes.sat_boxes import PlacedBox

REST = (1.0, 0.0, 0.0, 0.0)
ORIGIN = (0.0, 0.0, 0.0)
UNIT = (1.0, 1.0, 1.0)
CUBE = PlacedBox(UNIT, ORIGIN, REST)

extent = st.floats(0.2, 3.0)
sizes = st.tuples(extent, extent, extent)
places = st.tuples(*[st.floats(-2.0, 2.0)] * 3)
quaternions = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: sum(c * c for c in q) > 0.01)
    .map(lambda q: tuple(float(c) for c in np.array(q) / np.linalg.norm(q)))
)
boxes = st.builds(PlacedBox, sizes, places, quaternions)


def cube(place, turn=REST):
    return PlacedBox(UNIT, place, turn)
