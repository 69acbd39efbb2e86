"""Another package brings an engine and claims by entry points; one that is broken is a row that names it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ENGINE = '''
"""What is the volume of a convex hull? Asked of Qhull."""

from scipy.spatial import ConvexHull

PACKAGES = {"acme_hulls": "acme-hulls"}
KIND = "third-party engine"
SETTINGS = {"no joggled input": "the points are given"}


def hull_volume(points):
    return ConvexHull(points).volume
'''

CLAIMS = '''
"""Volumes beside those of hulls."""

import softbody
from softbody.geometry import polyhedron
from validation.check import Comparison, check
from validation.fault import Fault

FAMILY = "hulls of ACME"


@check(
    section="2.3",
    piece="softbody.geometry.polyhedron.signed_volume",
    reference="ACME's hulls",
    engines=("acme_hulls",),
    tolerance=1e-12,
    because="rounding of some hundred terms",
    faults=(Fault("volume off by 1e-11", polyhedron.signed_volume, "six_ / 6.0 → six_ / 6.0 * (1.0 + 1e-11)"),),
)
def volumes(run):
    "The volume of a convex mesh is that of its hull."
    from acme_hulls.reference import hull_volume

    solids = [softbody.box(tuple(size), 1) for size in run.fresh_rng().uniform(0.1, 2.0, (10, 3))]
    found = [polyhedron.signed_volume(mesh.vertices, mesh.triangles) for mesh in solids]
    hulls = [hull_volume(mesh.vertices) for mesh in solids]
    return Comparison(found, hulls, hulls, inputs={"vertices": [mesh.vertices for mesh in solids]})
'''

SUBJECT = '''
"""Qhull's Delaunay triangulation as if every mesh were convex."""

from scipy.spatial import Delaunay

PACKAGES = {"acme_hulls": "acme-hulls"}
CANNOT = {"move_boxes": "hulls stand still"}


def points_in_mesh(points, vertices, triangles):
    return Delaunay(vertices).find_simplex(points) >= 0
'''

BROKEN = {  # module → its text, and what is said of it
    "absent": (None, "No module named 'acme_broken.absent'"),
    "raises": ("raise ValueError('no licence \\x1b[2J')", "no licence \\x1b[2J"),
    "exits": ("import sys\nsys.exit(0)", "SystemExit: 0"),
    "aborts": ("import os\nos.abort()", "its import ends the process (signal 6)"),
    "leaves": ("import os\nos._exit(0)", "its import ends the process (exit status 0)"),
    "no_python": ("def", "SyntaxError"),
    "no_engine": (CLAIMS.replace("acme_hulls", "crystal_ball"), "leans on 'crystal_ball'"),
    "half": (CLAIMS.replace('("acme_hulls",)', '("scipy",)') + "\n1 / 0\n", "ZeroDivisionError"),
}


def install(folder: Path, package: str, files: dict[str, str | None], points: str) -> None:
    """Put a package into a folder as an installer would."""
    (folder / package).mkdir()
    for name, text in {"__init__": "", **files}.items():
        if text is not None:
            (folder / package / f"{name}.py").write_text(text, encoding="utf-8")
    info = folder / f"{package}-1.2.dist-info"
    info.mkdir()
    name = package.replace("_", "-")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(points, encoding="utf-8")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a sound plug-in and one whose every module is broken."""
    folder = tmp_path_factory.mktemp("site")
    points = "[softbody.engines]\nhulls = acme_hulls.reference\n[softbody.claims]\nhulls = acme_hulls.claims\n"
    points += "[softbody.subjects]\nhulls = acme_hulls.subject\n"
    install(folder, "acme_hulls", {"reference": ENGINE, "claims": CLAIMS, "subject": SUBJECT}, points)
    lines = [f"{name} = acme_broken.{name}" for name in BROKEN]
    points = "\n".join(["[softbody.claims]", *lines, "[softbody.engines]", "odd = acme_broken.odd", "gone = nowhere.x"])
    modules = {name: text for name, (text, _) in BROKEN.items()} | {"odd": "PACKAGES = {'a': open('b')}"}
    install(folder, "acme_broken", modules, points)
    return folder


def validate(installed: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m validation` where the plug-ins are installed; without the compiler, which few claims need."""
    path = os.pathsep.join([str(ROOT), str(installed)])
    variables = {**os.environ, "PYTHONPATH": path, "NUMBA_DISABLE_JIT": "1", "COLUMNS": "200"}
    command = [sys.executable, "-m", "validation", "--level", "quick", *options]
    return subprocess.run(command, env=variables, cwd=ROOT, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def run(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[subprocess.CompletedProcess[str], dict]:
    """Return what a run of the plug-ins' claims said, and its record."""
    pytest.importorskip("scipy")
    out = tmp_path_factory.mktemp("out")
    done = validate(installed, "-k", "acme", "-k", "rigid.thrown_box", "--out", str(out))
    return done, json.loads((out / "report.json").read_text(encoding="utf-8"))


def test_a_claim_of_another_package_is_judged_by_its_engine(run: tuple) -> None:
    done, report = run
    claims = {claim["id"]: claim for claim in report["claims"]}
    claim = claims["acme_hulls.claims.volumes"]
    assert (claim["verdict"], claim["n"], claim["kind"]) == ("holds", 10, "third-party engine"), claim["why"]
    assert report["engines"]["acme_hulls"] == "1.2"
    assert claims["rigid.thrown_box"]["verdict"] == "holds"
    assert done.returncode == 0


def test_a_plug_in_that_is_broken_is_one_row_that_names_it(run: tuple) -> None:
    done, report = run
    rows = {claim["id"]: claim for claim in report["claims"]}
    for name, (_, said) in BROKEN.items():
        row = rows.pop(f"softbody.claims.acme-broken.{name}")
        assert row["verdict"] == "engine broken"
        assert f"acme-broken (entry point acme_broken.{name}) is broken" in row["why"]
        assert said in row["why"]
    assert 'PACKAGES is not as {"a text": "a text"}' in rows.pop("softbody.engines.acme-broken.odd")["why"]
    assert "there is no module nowhere.x" in rows.pop("softbody.engines.acme-broken.gone")["why"]
    assert set(rows) == {"acme_hulls.claims.volumes", "rigid.thrown_box"}, "a half-declared claim is left"
    assert "Traceback" not in done.stdout + done.stderr


def test_who_demands_all_engines_is_told_of_a_broken_plug_in(installed: Path, tmp_path: Path) -> None:
    done = validate(installed, "-k", "acme-broken.odd", "--require-all", "--out", str(tmp_path))
    assert done.returncode == 3
    assert "acme-broken" in done.stdout


def test_an_engine_of_a_plug_in_can_be_demanded_and_replayed(installed: Path) -> None:
    done = validate(installed, "replay", "acme_hulls.claims.volumes")
    assert done.returncode == 0, done.stderr


def test_another_package_brings_a_subject(installed: Path, tmp_path: Path) -> None:
    options = ["--subject", "hulls", "-k", "inside.stacked", "-k", "boxes.fly", "--require", "acme_hulls"]
    assert validate(installed, *options, "--out", str(tmp_path)).returncode == 1
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert report["subject"] == {"name": "hulls", "version": "1.2"}
    fate = {claim["id"]: (claim["verdict"], claim["why"]) for claim in report["claims"]}
    assert fate["hulls:boxes.fly"] == ("not run", "hulls stand still")
    assert fate["hulls:inside.stacked"][0] == "fails", "a torus is not convex"
