#!/usr/bin/env python
"""Builds the source archive and the wheel of the last commit twice, and compares both files byte for byte.

    scripts/release/reproducible.py [--out DIR]

Each build is a call of `scripts/release/wheel` in a clone of its own. The builds differ in what the files may not
depend on: the folder, the home, the time zone, the language, the mask of new files, the number of parallel jobs.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Build:
    """What differs between two builds: a name of the folder, the mask of new files, and environment variables."""

    folder: str
    mask: int
    variables: dict[str, str]

    def run(self, commit: str, out: Path) -> Path:
        """The folder with the files that are built of a commit: a new one in `out`."""
        home, clone, built = (out / self.folder / name for name in ("home", "clone", "built"))
        home.mkdir(parents=True)
        for command in (["clone", "--quiet", str(ROOT), str(clone)], ["-C", str(clone), "checkout", "--quiet", commit]):
            subprocess.run(["git", *command], check=True, umask=self.mask)
        environment = {**os.environ, "HOME": str(home), **self.variables}
        environment.pop("SOURCE_DATE_EPOCH", None)
        build = [str(clone / "scripts" / "release" / "wheel"), "--out", str(built)]
        if subprocess.run(build, check=False, env=environment, umask=self.mask).returncode:
            sys.exit(f"The build in {clone} failed; the lines above say why.")
        return built


BUILDS = (
    Build("first", 0o022, {"TZ": "UTC", "LC_ALL": "C", "CMAKE_BUILD_PARALLEL_LEVEL": "2"}),
    Build("another/folder", 0o077, {"TZ": "Asia/Tokyo", "LC_ALL": "C.UTF-8", "CMAKE_BUILD_PARALLEL_LEVEL": "3"}),
)


def members(archive: Path) -> dict[str, str]:
    """The members of an archive by name: their contents, times and modes as text, shortened by a check sum."""
    found = {}
    if archive.suffix == ".whl":
        with zipfile.ZipFile(archive) as opened:
            for info in opened.infolist():
                check_sum = hashlib.sha256(opened.read(info)).hexdigest()
                found[info.filename] = f"{check_sum} {info.date_time} {info.external_attr >> 16:o}"
    else:
        with tarfile.open(archive) as opened_tar:
            for member in opened_tar:
                file = opened_tar.extractfile(member)
                check_sum = hashlib.sha256(file.read() if file else b"").hexdigest()
                owner = (member.uid, member.gid, member.uname, member.gname)
                found[member.name] = f"{check_sum} {member.mtime} {member.mode:o} {owner}"
    return found


def differences(first: Path, second: Path) -> Iterator[str]:
    """A line for each member in which two archives of the same name differ."""
    if first.read_bytes() == second.read_bytes():
        return
    ours, theirs = members(first), members(second)
    for name in sorted(ours.keys() | theirs.keys()):
        if ours.get(name) != theirs.get(name):
            yield f"{first.name}: {name}: {ours.get(name, 'missing')} and {theirs.get(name, 'missing')}"
    if ours == theirs:
        yield f"{first.name}: the members are equal; their order or compression differs"


def compare(first: Path, second: Path) -> bool:
    """Print the check sums of two folders' files, and where they differ; True if all are equal."""
    names = sorted({file.name for folder in (first, second) for file in folder.iterdir()})
    equal = True
    for name in names:
        for folder in (first, second):
            file = folder / name
            print(hashlib.sha256(file.read_bytes()).hexdigest() if file.exists() else "missing".ljust(64), file)
        if not ((first / name).exists() and (second / name).exists()):
            equal = False
            continue
        for line in differences(first / name, second / name):
            equal = False
            print(line)
    print("The builds are equal." if equal else "The builds differ.")
    return equal


def main() -> int:
    """Build twice and compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "reproducible", help="a folder, which is emptied")
    out = parser.parse_args().out.resolve()
    shutil.rmtree(out, ignore_errors=True)
    show = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
    commit = subprocess.run(show, check=True, capture_output=True, text=True).stdout.strip()
    print("Commit", commit, flush=True)
    first, second = (build.run(commit, out) for build in BUILDS)
    return not compare(first, second)


if __name__ == "__main__":
    sys.exit(main())
