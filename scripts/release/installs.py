#!/usr/bin/env python
"""Installs built wheels in new environments by pip, uv and pipx, plays there, and prints a row for each.

    scripts/release/installs.py build/wheels [--pythons 3.10 3.12] [--out DIR]

The rows are all Pythons from 3.10 to 3.14 that are found here with the newest dependencies, and Python 3.10 with the
oldest dependencies that the package declares. Wheels of the dependencies are downloaded first. Then each row
installs and plays without network, with a home that cannot be written to, and without a compiler or another program on
the PATH. All rows must play the same bytes. It needs Linux: `unshare` takes the network away.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from quickstart import fitting_wheel  # noqa: E402

VERSIONS = tuple(f"3.{minor}" for minor in range(10, 15))
INSTALLERS = ("pip", "uv", "pipx")
PLAY = """
import sys, zlib
import gymnasium, numpy as np
import atari
check_sum = 0
for obs_type in ("rgb", "ram"):
    env = atari.make("breakout", obs_type=obs_type)
    env.reset(seed=0)
    for step in range(100):
        observation, *_ = env.step(step % 4)
        check_sum = zlib.crc32(np.ascontiguousarray(observation), check_sum)
    env.close()
envs = atari.AtariVectorEnv("breakout", num_envs=4, preset="dqn2015")
envs.reset(seed=0)
for step in range(100):
    observations, *_ = envs.step(np.full(4, step % 4))
    check_sum = zlib.crc32(np.ascontiguousarray(observations), check_sum)
envs.close()
print(f"{check_sum:08x}", np.__version__, gymnasium.__version__)
"""
"""Plays 100 steps of pixels, of RAM and of a vector; prints a check sum of all observations, and versions."""


class Failed(Exception):
    """A command of a row failed; the text is the end of its output."""


def run(command: list[str], **variables: str) -> str:
    """The output of a command.

    Raises:
        Failed: it ended with an error.
    """
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **variables})
    if done.returncode:
        raise Failed((done.stderr or done.stdout).strip()[-2000:])
    return done.stdout


def find_python(version: str) -> str | None:
    """A Python of a version that runs here: on the PATH, of pyenv, or fetched by uv."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    uv = Path(os.environ.get("UV_PYTHON_INSTALL_DIR", Path.home() / ".local" / "share" / "uv" / "python"))
    folders = [*sorted(pyenv.glob(f"{version}.*")), *sorted(uv.glob(f"cpython-{version}.*"))]
    show = "import sys; print('%d.%d' % sys.version_info[:2])"
    for python in (shutil.which(f"python{version}"), *(str(folder / "bin" / f"python{version}") for folder in folders)):
        if python and Path(python).exists():
            done = subprocess.run([python, "-c", show], capture_output=True, text=True, check=False)
            if done.stdout.strip() == version:
                return python
    return None


def oldest_dependencies(wheel: Path) -> str:
    """The oldest release of each dependency of a wheel that its metadata allow, as constraints of pip."""
    with zipfile.ZipFile(wheel) as opened:
        name = next(name for name in opened.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = opened.read(name).decode()
    needed = re.findall(r"^Requires-Dist: ([\w-]+)>=([\w.]+)(?!.*extra ==)", metadata, re.MULTILINE)
    return "".join(f"{package}=={release}\n" for package, release in needed)


@dataclass
class Dependencies:
    """A folder with wheels of the package and of its dependencies for one Python.

    Attributes:
        python: the command of the Python.
        version: its version, such as "3.12".
        age: "oldest" or "newest".
        folder: the folder with the wheels.
        wheel: the package's wheel in it; None if no built wheel fits this Python.
    """

    python: str
    version: str
    age: str
    folder: Path
    wheel: Path | None = None

    def download(self, built: Path) -> None:
        """Fill the folder, from the index but for the package.

        Raises:
            Failed: a dependency has no wheel for this Python.
        """
        self.folder.mkdir(parents=True)
        wheel = fitting_wheel(self.python, [str(built)])
        if wheel is None:
            return
        self.wheel = Path(shutil.copy(wheel, self.folder))
        limits = self.folder / "limits.txt"
        limits.write_text(oldest_dependencies(self.wheel) if self.age == "oldest" else "", encoding="utf-8")
        command = [self.python, "-m", "pip", "download", "--quiet", "--only-binary=:all:", "--dest", str(self.folder)]
        run([*command, "--constraint", str(limits), str(self.wheel)])

    def rom_files(self, newest: "Dependencies") -> Path:
        """A folder with the ROM files of the newest ale-py, since the oldest has none."""
        folder = self.folder / "roms"
        with zipfile.ZipFile(next(newest.folder.glob("ale_py-*.whl"))) as opened:
            for name in opened.namelist():
                if name.endswith(".bin"):
                    folder.mkdir(exist_ok=True)
                    (folder / Path(name).name).write_bytes(opened.read(name))
        return folder


class Row:
    """A new environment: its folder, and the variables and the sandbox in which its commands run."""

    def __init__(self, folder: Path, tools: Path, dependencies: Dependencies, variables: dict[str, str]) -> None:
        self.folder, self.tools, self.dependencies = folder, tools, dependencies
        for name in ("home", "no-programs"):
            (folder / name).mkdir(parents=True)
        self.variables = {
            "HOME": str(folder / "home"),
            "PATH": str(folder / "no-programs"),
            "LC_ALL": "C.UTF-8",
            "UV_CACHE_DIR": str(folder / "cache"),
            "PIPX_HOME": str(folder / "pipx"),
            "PIPX_BIN_DIR": str(folder / "bin"),
            "PIPX_MAN_DIR": str(folder / "man"),
            "PIP_NO_INDEX": "1",
            "PIP_FIND_LINKS": str(dependencies.folder),
            **variables,
        }

    def run(self, *command: str | Path) -> str:
        """The output of a command without network, with an empty home that cannot be written to.

        Raises:
            Failed: it ended with an error.
        """
        programs = {name: shutil.which(name) or name for name in ("env", "unshare", "sh", "mount")}
        variables = [f"{name}={value}" for name, value in self.variables.items()]
        rights = [] if os.geteuid() == 0 else ["--map-root-user"]
        begin = '"$0" -t tmpfs -o ro none "$HOME" && exec "$@"'
        enter = [programs["unshare"], *rights, "--net", "--mount", programs["sh"], "-c", begin, programs["mount"]]
        return run([programs["env"], "-i", *variables, *enter, *map(str, command)])

    def install(self, installer: str) -> Path:
        """Install the package; the folder with the environment's commands."""
        python, wheel = self.dependencies.python, str(self.dependencies.wheel)
        environment = self.folder / "environment"
        offline = ("--no-index", "--find-links", str(self.dependencies.folder))
        if installer == "pip":
            self.run(python, "-m", "venv", environment)
            self.run(environment / "bin" / "python", "-m", "pip", "install", "--quiet", *offline, wheel)
        elif installer == "uv":
            self.run(self.tools / "uv", "venv", "--quiet", "--offline", "--python", python, environment)
            interpreter = environment / "bin" / "python"
            uv_install = (self.tools / "uv", "pip", "install", "--quiet", "--offline")
            self.run(*uv_install, "--python", interpreter, *offline, wheel)
        else:
            self.run(self.tools / "pipx", "install", "--python", python, "--pip-args", " ".join(offline), wheel)
            environment = self.folder / "pipx" / "venvs" / "atari-envs"
            self.run(self.folder / "bin" / "atari", "--version")
        return environment / "bin"

    def play(self, commands: Path) -> list[str]:
        """The check sum of what was played, and the versions of NumPy and Gymnasium."""
        self.run(commands / "atari", "--version")
        return self.run(commands / "python", "-I", "-c", PLAY).split()


def download_all(built: Path, out: Path, versions: list[str]) -> Iterator[Dependencies]:
    """The downloaded dependencies of each Python that is found, the newest ones first; those not found are printed."""
    found = {version: python for version in versions if (python := find_python(version))}
    for version in versions:
        if version not in found:
            print(f"Python {version} was not found.", flush=True)
    oldest = [(version, "oldest") for version in VERSIONS[:1] if version in found]
    for version, age in [*((version, "newest") for version in found), *oldest]:
        dependencies = Dependencies(found[version], version, age, out / f"wheels-{version}-{age}")
        try:
            dependencies.download(built)
        except Failed as failure:
            sys.exit(f"The {age} dependencies could not be downloaded for Python {version}:\n{failure}")
        if dependencies.wheel:
            yield dependencies
        else:
            print(f"No wheel in {built} fits Python {version}.", flush=True)


def main() -> int:
    """Download, then install and play in each row."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("wheels", type=Path, help="the folder with the built wheels")
    parser.add_argument("--pythons", nargs="+", choices=VERSIONS, default=[*VERSIONS], help="only these (default: all)")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "installs", help="a folder, which is emptied")
    chosen = parser.parse_args()
    out = chosen.out.resolve()
    shutil.rmtree(out, ignore_errors=True)
    run([sys.executable, "-m", "venv", str(out / "tools")])
    requirements = str(ROOT / "scripts" / "release" / "tools.txt")
    run([str(out / "tools" / "bin" / "pip"), "install", "--quiet", "--require-hashes", "-r", requirements])
    all_dependencies = [*download_all(chosen.wheels.resolve(), out, chosen.pythons)]

    print("| installer | Python | dependencies | NumPy | Gymnasium | check sum of what was played | seconds |")
    print("|---|---|---|---|---|---|---|", flush=True)
    check_sums, failures = set(), 0
    for dependencies in all_dependencies:
        # The oldest dependencies make no difference to pipx, which has pip or uv install them.
        for installer in INSTALLERS if dependencies.age == "newest" else INSTALLERS[:2]:
            label = f"| {installer} | {dependencies.version} | {dependencies.age} |"
            roms = {}
            if dependencies.age == "oldest":
                roms["ATARI_ROMS"] = str(dependencies.rom_files(all_dependencies[0]))
            row = Row(out / f"{installer}-{dependencies.folder.name}", out / "tools" / "bin", dependencies, roms)
            started = time.monotonic()
            try:
                check_sum, numpy, gymnasium = row.play(row.install(installer))
            except Failed as failure:
                failures += 1
                print(f"{label} failed:\n{failure}", flush=True)
                continue
            check_sums.add(check_sum)
            seconds = time.monotonic() - started
            print(f"{label} {numpy} | {gymnasium} | {check_sum} | {seconds:.0f} |", flush=True)
            shutil.rmtree(row.folder)
    if failures or len(check_sums) != 1:
        print(f"{failures} rows failed, and {len(check_sums)} different check sums were played.")
        return 1
    print("All rows played the same bytes.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
