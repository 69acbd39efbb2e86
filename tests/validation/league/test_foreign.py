"""An engine in a process of its own answers in arrays, or says why it does not; it may end, and is begun again."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from validation import effort, foreign
from validation.check import NotHereError
from validation.foreign import Engine, ForeignError
from validation.foreign.__main__ import made

TOY = """
import json, struct, sys
import numpy as np

def take(count):
    bytes = sys.stdin.buffer.read(count)
    if len(bytes) < count:
        sys.exit()
    return bytes

while True:
    (length,) = struct.unpack("<d", take(8))
    asked = json.loads(take(int(length)))
    rows = {}
    for name, shape in asked["shapes"].items():
        rows[name] = np.frombuffer(take(8 * int(np.prod(shape))), "<f8").reshape(shape)
    print("flood " * 100, file=sys.stderr)
    if asked["ask"] == "end":
        sys.exit(3)
    if asked["ask"] == "garbage":
        sys.stdout.buffer.write(b"hello, world, here is no answer")
        sys.stdout.buffer.flush()
        continue
    if asked["ask"] == "raise":
        said, answer = {"error": "no such thing"}, []
    else:
        doubled = asked["numbers"]["factor"] * rows["x"]
        said, answer = {"shapes": {"y": doubled.shape}, "seconds": 0.25}, [doubled]
    head = json.dumps(said).encode()
    sys.stdout.buffer.write(struct.pack("<d", len(head)) + head + b"".join(one.tobytes() for one in answer))
    sys.stdout.buffer.flush()
"""


@pytest.fixture
def toy(tmp_path: Path):
    file = tmp_path / "toy.py"
    file.write_text(TOY, encoding="utf-8")
    one = Engine([sys.executable, str(file)])
    yield one
    one.stop()


def test_arrays_go_there_and_back_to_the_bit_with_the_seconds_of_the_steps(toy):
    x = np.random.default_rng(1).normal(size=(3, 4, 2))
    x[0, 0] = [np.inf, -0.0]
    effort.taken()
    answer = toy.ask("double", {"factor": 2.0}, x=x)["y"]
    assert np.array_equal(answer, 2.0 * x)
    assert effort.taken() == 0.25
    assert toy.ask("double", {"factor": 1.0}, x=np.zeros((0, 3)))["y"].shape == (0, 3)


@pytest.mark.parametrize(
    ("question", "why"), [("raise", "no such thing"), ("end", "it has ended"), ("garbage", "no length")]
)
def test_what_is_no_answer_is_said_and_the_next_question_is_answered(toy, question, why):
    with pytest.raises(ForeignError, match=why):
        toy.ask(question, {}, x=np.zeros(2))
    assert np.array_equal(toy.ask("double", {"factor": 2.0}, x=np.ones(2))["y"], [2.0, 2.0])


def test_an_environment_that_is_not_made_is_named_with_the_command_that_makes_it(monkeypatch, tmp_path):
    monkeypatch.setattr(foreign, "ENVIRONMENTS", tmp_path)
    monkeypatch.setattr(foreign.shutil, "which", lambda _: "/bin/node")
    with pytest.raises(NotHereError, match=r"python -m validation\.foreign jolt"):
        foreign.engine("jolt")
    monkeypatch.setattr(foreign.shutil, "which", lambda _: None)
    with pytest.raises(NotHereError, match="Node is not installed"):
        foreign.engine("jolt")


def test_jolt_answers_where_node_is():
    from validation.subject import Boxes
    from validation.subjects import jolt

    if why := made("jolt", print):
        pytest.skip(why)
    one = Boxes(np.ones((1, 3)), np.ones(1), np.zeros((1, 3)), np.eye(4)[:1], np.ones((1, 3)), np.zeros((1, 3)), 9.81)
    try:
        end = jolt.move_boxes(one, 0.01, 100, 50)
    except NotHereError as error:
        pytest.skip(str(error))
    finally:
        foreign.stop()
    assert end.position.shape == (2, 1, 3)
    assert end.velocity[-1, 0] == pytest.approx([1.0, 1.0, 1.0 - 9.81], rel=1e-5)
