"""Import of optional libraries; where one is missing, the error names the command that installs it."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from importlib import import_module
from typing import Any

from softbody.compiler.interrupts import later
from softbody.errors import MissingPackageError


def library(name: str, package: str, extra: str, purpose: str) -> Any:
    """Return the module `name` of a `package` that an extra brings; raises MissingPackageError."""
    try:
        with nullcontext() if name in sys.modules else later():
            return import_module(name)
    except ImportError as error:
        raise MissingPackageError(f"{purpose} needs {package}: pip install softbody[{extra}]", name=name) from error
