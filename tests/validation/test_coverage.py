"""Does a record know what its claims leave out: errata of the paper, and public functions?"""

from __future__ import annotations

import softbody
from validation.check import all_checks
from validation.coverage import public_functions, unnamed_functions
from validation.errata import open_errata


def test_every_erratum_is_either_measured_or_open_and_none_is_missing() -> None:
    checks = list(all_checks().values())
    measured = [check.erratum.id for check in checks if check.erratum]
    known = measured + [erratum.id for erratum in open_errata(checks)]
    assert sorted(known, key=lambda name: int(name[1:])) == [f"E{k}" for k in range(1, 23)]


def test_errata_of_claims_that_are_not_run_say_so() -> None:
    found = {erratum.id: erratum for erratum in open_errata([])}
    assert list(found) == [f"E{k}" for k in range(1, 23)]
    assert "integrators.observed_order, is not part of this run" in found["E9"].why
    assert "softbody.dynamics.particle_ground" in found["E22"].why


def test_public_functions_are_there_and_those_that_claims_name_are_left_out() -> None:
    public, unnamed = list(public_functions()), unnamed_functions()
    assert {"softbody.World.step", "softbody.scenes.tray", "softbody.icosphere"} <= set(public)
    assert not [name for name in public if name.endswith("Error") or "._" in name]
    assert set(unnamed) < set(public)
    assert "softbody.World.step" not in unnamed
    for name in public:
        thing = softbody
        for part in name.split(".")[1:]:
            thing = getattr(thing, part)
