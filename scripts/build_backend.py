"""The build backend of the wheel: scikit-build-core, after a check that there is a C++20 compiler.

Without the check, a machine without a compiler shows two pages of CMake's output.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scikit_build_core import build as backend
from scikit_build_core.build import (
    build_sdist,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

Settings = Mapping[str, Any] | None


def check_compiler() -> None:
    """Exits with one sentence if no C++20 compiler is found."""
    if sys.platform == "win32":  # CMake finds compilers that PATH does not name
        return
    compilers = [os.environ["CXX"]] if os.environ.get("CXX") else ["c++", "g++", "clang++"]
    found = [compiler for compiler in compilers if shutil.which(shlex.split(compiler)[0])]
    if any(map(compiles_cpp20, found)):
        return
    why = f"{' and '.join(found)} cannot compile C++20" if found else f"none of {', '.join(compilers)} was found"
    sys.exit(
        f"atari-envs: no wheel fits this machine, and to build one takes a C++20 compiler: {why}; install GCC 12 or "
        "Clang 14 or newer (Debian: apt install g++; macOS: xcode-select --install), or set CXX."
    )


def compiles_cpp20(compiler: str) -> bool:
    """Whether the command `compiler` accepts a program that includes a header of C++20."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program.cpp"
        program.write_text("#include <concepts>\nint main() {}\n")
        command = [*shlex.split(compiler), "-std=c++20", "-c", str(program), "-o", str(program.with_suffix(".o"))]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """What the build of a wheel needs, by scikit-build-core (CMake and Ninja where they are missing)."""
    check_compiler()
    return backend.get_requires_for_build_wheel(config_settings)


def get_requires_for_build_editable(config_settings: Settings = None) -> list[str]:
    """What an editable installation needs."""
    check_compiler()
    return backend.get_requires_for_build_editable(config_settings)


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Builds the wheel and returns its file name."""
    check_compiler()
    return backend.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory: str, config_settings: Any = None, metadata_directory: str | None = None) -> str:
    """Builds the wheel of an editable installation and returns its file name."""
    check_compiler()
    return backend.build_editable(wheel_directory, config_settings, metadata_directory)
