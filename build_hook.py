"""Puts the machine code that `make wheel` has compiled into a wheel for one Python, one system and one processor."""

from __future__ import annotations

import os
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class MachineCode(BuildHookInterface):  # type: ignore[type-arg, misc]
    """Without SOFTBODY_MACHINE_CODE, which names a folder of it, the wheel is pure: py3-none-any."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the files, and say what the wheel is for."""
        folder = os.environ.get("SOFTBODY_MACHINE_CODE")
        if not folder or self.target_name != "wheel":
            return
        for path in sorted(Path(folder).rglob("*.nbc")):
            build_data["force_include"][str(path)] = f"softbody/_machine_code/{path.relative_to(folder).as_posix()}"
        build_data["pure_python"] = False
        build_data["tag"] = f"cp{sysconfig.get_config_var('py_version_nodot')}-none-{os.environ['SOFTBODY_PLATFORM']}"
