"""Motion without contact: springs, gas pressure, the integrators, rigid boxes, energy and momentum."""
