"""Names of the bodies and joints of a world: optional, and unique among them all."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from itertools import count

import numpy as np

from softbody.errors import ParameterError
from softbody.model.validation import shown

Who = tuple[str, int]  # "soft", "box", "joint" or "suspension", and its number among those of its kind

KINDS = {"soft": "soft body", "box": "box", "joint": "joint", "suspension": "suspension"}
MOST = 100  # characters
MOST_LISTED = 20  # names that a message lists
GONE = -1  # the number of what was removed


def checked_name(value: object, argument: str = "name") -> str:
    """Return what may be a name: 1 to 100 printable characters, no space first or last; raises ParameterError."""
    if not (isinstance(value, str) and 0 < len(value) <= MOST and value.isprintable() and value == value.strip()):
        raise ParameterError(
            f"{argument} is {shown(value)}; give a text of 1 to {MOST} characters that can be printed, without spaces "
            "around it"
        )
    return value


class Names:
    """Who has which name. It never changes: what changes a world's names gives it other Names."""

    __slots__ = ("_name", "_who")

    def __init__(self, who: dict[str, Who] | None = None, name: dict[Who, str] | None = None) -> None:
        """Take who has each name, and the name of each who has one."""
        self._who, self._name = who or {}, name or {}

    def __contains__(self, name: object) -> bool:
        """Tell whether there is such a name."""
        return isinstance(name, str) and name in self._who

    def who(self, name: object) -> Who:
        """Return who has a name; raises ParameterError, which lists the names that there are."""
        if isinstance(name, str) and name in self._who:
            return self._who[name]
        raise ParameterError(f"there is no {shown(name)} in this world; {names_listed(name, list(self._who))}")

    def name(self, who: Who) -> str | None:
        """Return the name of a body or joint, or None."""
        return self._name.get(who)

    def title(self, who: Who) -> str:
        """Return what messages call a body or joint: its kind, number and name."""
        name, (kind, index) = self._name.get(who), who
        return f"{KINDS[kind]} {index}" + (f" {name!r}" if name else "")

    def renamed(self, who: Who, value: object, argument: str = "name") -> Names:
        """Return the names where a body or joint has this one, or none; raises ParameterError."""
        name = None if value is None else checked_name(value, argument)
        before = self._name.get(who)
        if name == before:
            return self
        if name in self._who:
            kind, index = self._who[name]
            raise ParameterError(f"{argument} is {name!r}, which {KINDS[kind]} {index} has; give another")
        whose, called = dict(self._who), dict(self._name)
        if before is not None:
            del whose[before], called[who]
        if name is not None:
            whose[name], called[who] = who, name
        return Names(whose, called)

    def free_after(self, name: str | None) -> str | None:
        """Return what a piece of a body of a name is called: "ball.1", or the first such name that nobody has."""
        return next((f"{name}.{k}" for k in count(1) if f"{name}.{k}" not in self), None) if name else None

    def renumbered(self, number: Callable[[str, int], int]) -> Names:
        """Return the names where each kind and number has another `number`, or is GONE."""
        moved = {name: (kind, number(kind, index)) for name, (kind, index) in self._who.items()}
        stay = {name: who for name, who in moved.items() if who[1] != GONE}
        return Names(stay, {who: name for name, who in stay.items()})

    def words(self, counts: dict[str, int]) -> dict[str, np.ndarray]:
        """Return the names of all bodies and joints, "" for none: arrays of words, as long as `counts` says."""
        every = {kind: [self._name.get((kind, i), "") for i in range(count)] for kind, count in counts.items()}
        return {kind: np.array(words, np.str_) for kind, words in every.items()}


def names_of(words: dict[str, list[str]], entry: str) -> Names:
    """Return the names that `Names.words` gave, called `entry` in messages; raises ParameterError."""
    whose: dict[str, Who] = {}
    for kind, each in words.items():
        for i, word in enumerate(each):
            if word and checked_name(word, f"{entry}.{kind}[{i}]") in whose:
                raise ParameterError(f"{entry}.{kind}[{i}] is {word!r}, which another has; give each its own")
            if word:
                whose[word] = kind, i
    return Names(whose, {who: name for name, who in whose.items()})


def names_listed(meant: object, names: list[str]) -> str:
    """Say which names there are, and which one may be meant."""
    if not names:
        return "none has a name: give it one where it is added, name = …"
    close = get_close_matches(meant, names, 1) if isinstance(meant, str) else []
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"{hint}there are {', '.join(map(repr, names[:MOST_LISTED]))}{more}"
