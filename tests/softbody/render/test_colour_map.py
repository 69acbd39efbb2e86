"""The colour maps are those of their names."""

from __future__ import annotations

import numpy as np
import pytest

from softbody import ParameterError
from softbody.render.colour_map import COLOUR_MAPS, SHADES, palette_of


@pytest.mark.parametrize("name", COLOUR_MAPS)
def test_a_colour_map_is_that_of_matplotlib_to_four_percent(name):
    colormaps = pytest.importorskip("matplotlib").colormaps
    np.testing.assert_allclose(palette_of(name), colormaps[name](np.linspace(0.0, 1.0, SHADES))[:, :3], atol=0.04)


def test_another_name_is_refused():
    with pytest.raises(ParameterError, match="colour_map is 'jet'; choose one of viridis, coolwarm"):
        palette_of("jet")
