"""Does a small world of a kind call every kernel that worlds of that kind do?"""

from functools import partial

import pytest

from softbody.cli.warmup import KINDS, run_small_world
from softbody.stepping import runner

pytestmark = pytest.mark.interpreted


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind.self_contact])
def test_a_body_that_holds_itself_is_moved_far_from_itself_and_on_itself(kind, monkeypatch):
    called = set()

    def noted(name, kernel, *given):
        called.add(name)
        return kernel(*given)

    for name in ("run", "run_alone_by_clock"):
        monkeypatch.setattr(runner, name, partial(noted, name, getattr(runner, name)))
    monkeypatch.setattr("softbody.cli.warmup.next_look", lambda steps: 2)  # of the many steps two do
    run_small_world(kind)
    assert called == ({"run", "run_alone_by_clock"} if kind.boxes == 0 else {"run"})
