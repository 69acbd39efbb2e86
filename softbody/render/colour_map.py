"""Colour maps: the colours that stand for numbers."""

from __future__ import annotations

import numpy as np

from softbody.model.settings import check_name

# Seventeen colours of each, evenly spaced: viridis (van der Walt and Smith 2015) for what grows from nothing, coolwarm
# (Moreland 2009) for what has a middle. Between them it is linear, which is off by 3 % at most.
COLOUR_MAPS = {
    "viridis": "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1fa088 28ae80 3fbc73 5ec962 84d44b "
    "addc30 d8e219 fde725",
    "coolwarm": "3b4cc0 4e68d8 6282ea 779af7 8db0fe a3c2fe b9d0f9 ccd9ed dddcdc ecd3c5 f5c4ac f7b093 f4987a eb7d62 "
    "dd5f4b ca3b37 b40426",
}
SHADES = 256


def palette_of(name: str) -> np.ndarray:
    """Return the colours (SHADES, 3), 0 … 1, of a map from least to greatest; raises ParameterError for no name."""
    check_name(name, "colour_map", tuple(COLOUR_MAPS))
    given = np.array([[int(word[i : i + 2], 16) for i in (0, 2, 4)] for word in COLOUR_MAPS[name].split()]) / 255.0
    places = np.linspace(0.0, 1.0, SHADES), np.linspace(0.0, 1.0, len(given))
    return np.stack([np.interp(*places, given[:, k]) for k in range(3)], axis=1)
