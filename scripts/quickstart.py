#!/usr/bin/env python3
"""Sets up everything, shows a game, and measures frames a second beside ale-py on this machine. Safe to run again.

    scripts/quickstart                  Linux and macOS
    py scripts\\quickstart.py            Windows

A wheel of this version for this Python is taken from `dist` or `wheelhouse`, if there is one. Otherwise a wheel is
built, which needs a C++20 compiler. `scripts/setup.sh` uses `set_up` for the other scripts.
"""

import sys

if sys.version_info < (3, 10):  # noqa: UP036
    sys.exit("Python 3.10 or newer is needed, this is {}.{}; install a newer one.".format(*sys.version_info[:2]))

import argparse
import os
import platform
import re
import shutil
import subprocess
import venv as environments
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent.parent
WINDOWS = os.name == "nt"
WHEELS = ("dist", "wheelhouse")
"""Folders of the repository that may have a wheel: those that `python -m build` and cibuildwheel write."""

GET_COMPILER = {
    "Windows": (
        "install the Build Tools for Visual Studio with the workload 'Desktop development with C++' and its component "
        "'C++ Clang tools for Windows'"
    ),
    "Darwin": "install Apple's with: xcode-select --install",
    "Linux": "install GCC 12 or Clang 14 or newer (Debian: apt install g++)",
}
GET_VENV = {"Linux": "install Python's module venv (Debian: apt install python3-venv)"}
NETWORK = "It needs network access to PyPI or a mirror."


def say(text: str) -> None:
    """Print the heading of a step."""
    print(f"\n==> {text}", flush=True)


def fail(text: str) -> NoReturn:
    """End with a sentence."""
    sys.exit(f"\n!!! {text}")


def version() -> str:
    """The version of the sources."""
    found = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    assert found
    return found[1]


def command_of(venv: Path, name: str) -> str:
    """The path of a command in a virtual environment."""
    return str(venv / "Scripts" / f"{name}.exe" if WINDOWS else venv / "bin" / name)


def make_venv(venv: Path) -> None:
    """Make a virtual environment of this Python, unless there is one."""
    if Path(command_of(venv, "python")).exists():
        return
    say(f"Making the virtual environment {venv} with Python {platform.python_version()}")
    try:
        environments.create(venv, with_pip=True, symlinks=not WINDOWS)
    except (OSError, subprocess.CalledProcessError) as error:
        shutil.rmtree(venv, ignore_errors=True)
        advice = GET_VENV.get(platform.system(), "install Python again, with pip and venv")
        fail(f"{sys.executable} cannot make virtual environments ({error}); {advice}.")


def _compiles(compiler: str) -> bool:
    """True if a command compiles C++20."""
    if not shutil.which(compiler):
        return False
    command = [compiler, "-std=c++20", "-x", "c++", "-fsyntax-only", "-"]
    return not subprocess.run(command, input=b"int main() {}", capture_output=True, check=False).returncode


def _has_clang_of_visual_studio() -> bool:
    """True if Visual Studio's installer names an installation with clang, the compiler of the wheels for Windows."""
    programs = os.environ.get("PROGRAMFILES(X86)", "C:/Program Files (x86)")
    finder = Path(programs, "Microsoft Visual Studio", "Installer", "vswhere.exe")
    if not finder.exists():
        return False
    parts = [f"Microsoft.VisualStudio.Component.VC.{part}" for part in ("Llvm.Clang", "Llvm.ClangToolset")]
    command = [str(finder), "-latest", "-products", "*", "-requires", *parts, "-property", "installationPath"]
    return bool(subprocess.run(command, capture_output=True, check=False).stdout.strip())


def find_compiler() -> dict[str, str] | None:
    """The environment variables that a build needs for this system's C++20 compiler; None if there is no compiler."""
    if WINDOWS:
        return {"CMAKE_GENERATOR_TOOLSET": "ClangCL"} if _has_clang_of_visual_studio() else None
    compilers = [os.environ.get("CXX", ""), "c++", "g++", "clang++"]
    return {} if any(_compiles(compiler) for compiler in compilers if compiler) else None


def check_compiler(and_no: str = "") -> dict[str, str]:
    """`find_compiler`, which must have found one; `and_no` says what else is missing."""
    found = find_compiler()
    if found is None:
        fail(f"A C++20 compiler is missing{and_no}; {GET_COMPILER.get(platform.system(), GET_COMPILER['Linux'])}.")
    return found


def fitting_wheel(python: str, folders: Sequence[str]) -> Path | None:
    """A copy of the wheel in these folders that pip takes for this version of the package and this Python, or None."""
    found = ROOT / "build" / "fitting"
    shutil.rmtree(found, ignore_errors=True)
    links = [option for folder in folders if Path(folder).is_dir() for option in ("--find-links", folder)]
    # Isolated: a folder or an index of pip's configuration must not take part.
    command = [python, "-m", "pip", "--isolated", "download", "--no-deps", "--no-index", "--only-binary=:all:", *links]
    subprocess.run([*command, "--dest", str(found), f"atari-envs=={version()}"], capture_output=True, check=False)
    return next(found.glob("*.whl"), None)


def progress(lines: Iterator[str]) -> Iterator[str]:
    """The lines of progress, "[12/40] Building atari/emulator/...", so that they fit in 80 columns.

    The module is linked when two steps are left; the compiler then optimises all files at once, and prints nothing
    until it is done.
    """
    for line in lines:
        step = re.match(r" *\[ *(\d+)(?:%|/(\d+))\].*", line)
        if "Installing build dependencies: started" in line:
            yield "Installing build dependencies: started"
        if not step:
            continue
        text = re.sub(r" CXX object .*\.dir/(?:__/__/__/)?", " ", step[0])
        yield re.sub(r"\.(?:o|obj|cpython-.*)$", "", text)
        if step[2] and int(step[2]) - int(step[1]) == 2:
            yield "  Linking, with optimisation over all files: about a minute without a line"


def build_wheel(python: str, targets: str, variables: Mapping[str, str]) -> Path:
    """The wheel, built of the sources; the output is in build/wheel.log.

    Args:
        python: the Python whose wheel is built.
        targets: what CMake builds beside the wheel of the same objects, with semicolons between.
        variables: environment variables of the build.
    """
    say("Building the wheel (first time: one to five minutes; the whole output is in build/wheel.log)")
    shutil.rmtree(ROOT / "build" / "dist", ignore_errors=True)
    show = "import sys; print('cp%d%d' % sys.version_info[:2])"
    tag = subprocess.run([python, "-c", show], capture_output=True, text=True, check=True).stdout.strip()
    folder = Path("build", "wheel", tag)
    (ROOT / folder).mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, **variables, "SKBUILD_BUILD_DIR": str(folder)}
    if targets:
        environment["SKBUILD_BUILD_TARGETS"] = f"all;{targets}"
    command = [python, "-m", "pip", "wheel", "--verbose", "--no-deps", "--wheel-dir", "build/dist", "."]
    log = ROOT / "build" / "wheel.log"
    with log.open("w", encoding="utf-8") as file:
        build = subprocess.Popen(
            command,
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        assert build.stdout
        for line in progress(line for line in build.stdout if file.write(line)):
            print(line, flush=True)
        build.wait()
    if build.returncode:
        print(*log.read_text(encoding="utf-8").splitlines()[-40:], sep="\n", file=sys.stderr)
        fail(f"The wheel could not be built; the lines above say why. {NETWORK}")
    return next((ROOT / "build" / "dist").glob("*.whl"))


def set_up(venv: Path, extras: str, targets: str = "", options: str = "", wheels: Sequence[str] = ()) -> None:
    """Make a virtual environment that has the package with extras, and its dependencies.

    Args:
        venv: the folder of the environment.
        extras: names of extras, with commas between.
        targets: what CMake builds beside the wheel, with semicolons between.
        options: pip's options for the dependencies, with spaces between.
        wheels: folders that may have a fitting wheel; without one, a wheel is built.
    """
    if not wheels:
        check_compiler()
    make_venv(venv)
    python = command_of(venv, "python")
    wheel = fitting_wheel(python, wheels) if wheels else None
    if wheel:
        say(f"Taking {wheel.name} from {' or '.join(wheels)}; --build would build the sources")
    else:
        no_wheel = f", and {' or '.join(wheels)} has no wheel of atari-envs {version()} for this Python"
        wheel = build_wheel(python, targets, check_compiler(no_wheel if wheels else ""))
    say("Installing it with its dependencies (first time: a minute or two)")
    install = [python, "-m", "pip", "install", "--quiet", "--progress-bar", "off"]
    for arguments in ([*options.split(), f"{wheel}[{extras}]"], ["--force-reinstall", "--no-deps", str(wheel)]):
        if subprocess.run([*install, *arguments], cwd=ROOT, check=False).returncode:
            fail(f"The installation failed; the lines above say why. {NETWORK}")


def main() -> None:
    """Set up, write the video of a game, and measure."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--wheels", action="append", metavar="DIR", help="a folder that may have a fitting wheel")
    parser.add_argument("--build", action="store_true", help="build the sources, also if there is a fitting wheel")
    chosen = parser.parse_args()
    os.chdir(ROOT)
    venv = Path(".venv")
    set_up(venv, "video", wheels=() if chosen.build else chosen.wheels or WHEELS)
    Path("videos").mkdir(exist_ok=True)
    video = Path("videos", "qbert.mp4")
    render = [command_of(venv, "atari"), "replay", "render", "examples/qbert.a26r", "--stop", "1200", "-o", str(video)]
    for heading, command in (
        (f"Writing {video}: the first 20 seconds of examples/qbert.a26r, a game of 7,950 points", render),
        ("Measuring, for five seconds", [command_of(venv, "python"), "scripts/bench/quick.py"]),
    ):
        say(heading)
        status = subprocess.run(command, check=False).returncode
        if status:
            sys.exit(status)
    activate = r".venv\Scripts\activate" if WINDOWS else "source .venv/bin/activate"
    say(f"""Done. Look at {video.resolve()}, and try next:
      {activate}
      atari info qbert                                 # what a game has: modes, actions, names of its RAM
      atari record qbert --policy random -o mine.mp4   # a policy of yours in place of random
      atari train ppo pong --fast                      # needs pip install '.[learn,video]'""")


if __name__ == "__main__":
    main()
