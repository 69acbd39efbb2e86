"""Is USD's text read as its specification says? A file of two time codes, written here by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import usd

HALF = 2.0**-0.5

TEXT = f"""#usda 1.0
(
    metersPerUnit = 1
    timeCodesPerSecond = 10
    upAxis = "Z"
)

def Xform "World"
{{
    def Mesh "a" (
        displayName = "a \\"ball\\""
    )
    {{
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 2, 1]
        point3f[] points.timeSamples = {{
            0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
            10: [(0, 0, 0), (1, 0, 0), (0, 3, 0)],
        }}
        color3f[] primvars:displayColor = [(0.5, 0.25, 1)]
    }}

    def Mesh "b" (
        active = true
    )
    {{
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        quatd xformOp:orient.timeSamples = {{
            0: (1, 0, 0, 0),
            10: ({HALF}, 0, 0, {HALF}),
        }}
        double3 xformOp:translate = (5, 0, 1)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
    }}
}}
"""


@pytest.fixture
def stage(tmp_path):
    (tmp_path / "a.usda").write_text(TEXT)
    return usd.Stage(tmp_path / "a.usda")


def test_points_places_and_turns_at_a_time(stage):
    vertices, triangles = stage.shown(0.5)['a "ball"']
    assert_allclose(vertices, [(0, 0, 0), (1, 0, 0), (0, 2, 0)])
    assert triangles.tolist() == [[0, 2, 1]]
    assert_allclose(stage.shown(9.0)['a "ball"'][0][2], (0, 3, 0))
    assert_allclose(stage.shown(1.0)["b"][0], [(5, 0, 1), (5, 1, 1), (4, 0, 1)], atol=1e-15)
    assert_allclose(stage.shown(0.5)["b"][0][1], (5 + HALF, HALF, 1))
    assert_allclose(stage.shown(-1.0)["b"][0][1], (6, 0, 1))


def test_what_is_invisible_is_not_shown(tmp_path):
    words = 'token visibility.timeSamples = {\n            0: "invisible",\n            5: "inherited",\n        }'
    text = TEXT.replace("        color3f", f"        {words}\n        color3f", 1)
    (tmp_path / "a.usda").write_text(text)
    stage = usd.Stage(tmp_path / "a.usda")
    for time, titles in (
        (-1.0, {"b"}),
        (0.0, {"b"}),
        (0.49, {"b"}),
        (0.5, {'a "ball"', "b"}),
        (9.0, {'a "ball"', "b"}),
    ):
        assert set(stage.shown(time)) == titles


def test_binary_files_say_the_same(stage, tmp_path):
    sdf = pytest.importorskip("pxr.Sdf")
    sdf.Layer.OpenAsAnonymous(str(tmp_path / "a.usda")).Export(str(tmp_path / "a.usdc"))
    again = usd.Stage(tmp_path / "a.usdc").shown(0.25)
    for title, (vertices, triangles) in stage.shown(0.25).items():
        assert_allclose(again[title][0], vertices, atol=1e-15)
        assert np.array_equal(again[title][1], triangles)


def test_other_units_are_metres_here(stage, tmp_path):
    (tmp_path / "a.usda").write_text(TEXT.replace("metersPerUnit = 1", "metersPerUnit = 0.01"))
    assert_allclose(usd.Stage(tmp_path / "a.usda").shown(0.3)["b"][0], 0.01 * stage.shown(0.3)["b"][0])


def test_another_axis_is_refused(tmp_path):
    (tmp_path / "a.usda").write_text(TEXT.replace('"Z"', '"Y"'))
    with pytest.raises(ValueError, match="has not z up"):
        usd.Stage(tmp_path / "a.usda")
