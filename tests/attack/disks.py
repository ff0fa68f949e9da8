"""Full and failing disks under every writer of the package, each in a process of its own.

Right is: the writer says so in one sentence that names the file, it leaves no partial file and an older one as it was,
and the process lives on and writes the file once the disk has room.
"""

import json
import os
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import bad_disk

OLDER = b"an older file"
SECONDS = 300  # the runner calls 60 s a hang, on a machine that does nothing else
MAIN = "import attack.disks, sys; attack.disks.child(sys.argv[1], sys.argv[2])"
_SENTENCES = [os.strerror(number) for number in (5, 27, 28, 122)]  # EIO, EFBIG, ENOSPC, EDQUOT
_SENTENCES.append("HDF5 could not write")
_TAKEN = ("folder", "device", "directory", "exists", "already")


def attack(seed: int) -> None:
    """One writer on one disk."""
    import written_files

    source = random.Random(seed)
    name = source.choice([one for one in written_files.WRITTEN if not written_files.missing(one)])
    disk = bad_disk.draw(source, source.choice([kind for kind, reason in bad_disk.kinds().items() if not reason]))
    check(name, disk, size=int(2 ** source.uniform(0, 8)), older=source.random() < 0.5)


def missing() -> list[str]:
    """What is not played here, and why."""
    import written_files

    lacking = {name: written_files.missing(name) for name in written_files.WRITTEN}
    return [
        *(f"{name}: it needs {', '.join(packages)}" for name, packages in lacking.items() if packages),
        *(f"a {kind} disk: {reason}" for kind, reason in bad_disk.kinds().items() if reason),
    ]


def check(name: str, disk: dict[str, Any], size: int, older: bool) -> None:
    """Let a process write on a bad disk.

    Raises:
        AssertionError: it crashed, hung, or did something else than what is right.
    """
    case = json.dumps({"name": name, "disk": disk, "size": size, "older": older})
    with bad_disk.outside(disk) as (folder, environment):
        environment.update(
            PYTHONDONTWRITEBYTECODE="1",  # below a limit of a file's size, Python writes half a file of bytecode
            PYTHONPATH=os.pathsep.join(filter(None, sys.path)),
            SDL_VIDEODRIVER="dummy",
            SDL_AUDIODRIVER="dummy",
        )
        words = [sys.executable, "-X", "faulthandler", "-c", MAIN, case, str(folder)]
        inputs = folder.parent / "inputs"
        inputs.mkdir()
        try:
            done = subprocess.run(words, cwd=inputs, env=environment, capture_output=True, text=True, timeout=SECONDS)
        except subprocess.TimeoutExpired as error:
            raise AssertionError(f"{case}: it hung; {error.stderr!r}") from None
    assert done.returncode == 0, f"{case}: status {done.returncode}: {done.stdout[-500:]}{done.stderr[-2000:]}"
    for text in ("Traceback", "Exception ignored"):
        assert text not in done.stderr, f"{case}: {done.stderr[-2000:]}"


def child(text: str, place: str) -> None:
    """The process that writes."""
    import written_files

    case, folder = json.loads(text), Path(place)
    written = written_files.WRITTEN[case["name"]]
    disk = bad_disk.Disk(case["disk"], folder)
    target = folder / written.name
    older = case["older"] and written.replaces and "." in target.name and "%" not in target.name
    write = written.prepare(case["size"])
    if older and disk.kind != "taken":
        target.write_bytes(OLDER)
    os.environ["TMPDIR"] = str(folder)
    disk.spoil(target)
    said = outcome(written_files, write, target)
    if said is not None:
        if disk.kind == "taken":
            assert disk.is_untouched(target), f"what had the name is gone: {said}"
        else:
            check_left(written_files, written, folder, target, OLDER if older else None)
        disk.repair(target)
        if written.name == "run":
            target = folder / "again"
        again = outcome(written_files, write, target)
        assert again is None, f"with room, it said {again}"
    written_files.read(target if "%" not in target.name else folder)


def outcome(written_files: Any, write: Any, target: Path) -> str | None:
    """What a writer says: nothing, or the sentence of its error, which must name a file and a reason."""
    said, reasons = None, (*_SENTENCES, *_TAKEN)
    try:
        write(target)
    except OSError as error:
        said = f"{error.strerror or error}: {error.filename}"
    except written_files.CommandFailed as error:
        said = sentence(error)
    except ValueError as error:
        said, reasons = str(error), _TAKEN
    if said is not None and not (str(target.parent) in said and any(reason in said for reason in reasons)):
        raise AssertionError(f"no file or no reason: {said}")
    return said


def sentence(error: Any) -> str:
    """The sentence of a command that failed."""
    errors = [line for line in error.errors.splitlines() if line.startswith("atari: error: ")]
    if error.code != 1 or len(errors) != 1:
        raise AssertionError(f"status {error.code}, not one sentence: {error.errors}")
    return errors[0]


def check_left(written_files: Any, written: Any, folder: Path, target: Path, older: bytes | None) -> None:
    """Check what a failed writer leaves: the older file, or the whole files and the beginning of a recording."""
    left = [path for path in folder.rglob("*") if path.is_file() and path.name != "filler"]
    for path in left:
        if path == target and older is not None and path.read_bytes() == older:
            continue
        assert written.keeps, f"it left {path} with {path.stat().st_size} bytes"
        written_files.read(path)
    assert older is None or target in left, "the older file is gone"
