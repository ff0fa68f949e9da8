"""Runs the attackers in child processes, one a core, since what they look for are crashes and hangs.

python -m attack --seconds 300         all attackers
python -m attack roms --seed 17       one seed again, in this process
"""

import argparse
import importlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ATTACKERS = tuple(
    sorted(
        path.stem for path in Path(__file__).parent.glob("*.py") if "\ndef attack(" in path.read_text(encoding="utf-8")
    )
)
REPORT_MISSING = ("disks",)  # they have a function `missing`, which says what is not played here, and why
NEED_TORCH = ("crashes", "observations", "runs")
HANGS_AFTER = 240.0  # seconds without a new seed: a machine may have other work


def main() -> int:
    parser = argparse.ArgumentParser(prog="attack", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "attackers", nargs="*", metavar="ATTACKER", help=f"one of {', '.join(ATTACKERS)} (default: all)"
    )
    parser.add_argument("--seconds", type=float, default=300.0, help="of play, all of them together (default 300)")
    parser.add_argument("--seed", type=int, help="play this seed alone, in this process")
    parser.add_argument("--first-seed", type=int, default=None, help="default: by the clock, so that runs differ")
    parser.add_argument("--until", type=float, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if unknown := set(arguments.attackers) - set(ATTACKERS):
        parser.error(f"there is no attacker {sorted(unknown)[0]!r}; there are {', '.join(ATTACKERS)}")
    names = arguments.attackers or ATTACKERS
    if not arguments.attackers and importlib.util.find_spec("torch") is None:
        names = [name for name in ATTACKERS if name not in NEED_TORCH]
        print(f"{', '.join(NEED_TORCH)}: NOT run, because they need PyTorch", flush=True)
    for name in () if arguments.seed is not None or arguments.until is not None else names:
        if name in REPORT_MISSING:
            for line in importlib.import_module(f"attack.{name}").missing():
                print(f"{name}: NOT played: {line}", flush=True)
    with tempfile.TemporaryDirectory() as home:
        os.environ.update(HOME=home, XDG_DATA_HOME=home)  # your own ROM files stay out of it
        return run(arguments, names)


def run(arguments: argparse.Namespace, names: Sequence[str]) -> int:
    """One seed, a child's seeds, or all attackers; 1 if something was found."""
    if arguments.seed is not None:
        for name in names:
            importlib.import_module(f"attack.{name}").attack(arguments.seed)
        return 0
    if arguments.until is not None:
        return play(names[0], arguments.first_seed, arguments.until)
    first = int(time.time()) if arguments.first_seed is None else arguments.first_seed
    # On a core each: together they take as long as one after the other on one core.
    side_by_side = min(os.cpu_count() or 1, len(names))
    with ThreadPoolExecutor(side_by_side) as pool:
        seconds = arguments.seconds / len(names)
        results = list(pool.map(lambda name: watch(name, first, seconds), names))
    return 0 if all(results) else 1


def play(name: str, seed: int, until: float) -> int:
    """Seed after seed, each written out before it is played."""
    attack = importlib.import_module(f"attack.{name}").attack
    while time.time() < until:
        print(seed, flush=True)
        attack(seed)
        seed += 1
    return 0


def watch(name: str, first: int, seconds: float) -> bool:
    """Whether a child that plays seeds for so long ends well; reports the seed otherwise."""
    command = [sys.executable, "-m", "attack", name, "--first-seed", str(first), "--until", str(time.time() + seconds)]
    with tempfile.TemporaryDirectory() as folder:
        seeds, errors = Path(folder, "seeds"), Path(folder, "errors")
        with seeds.open("w") as out, errors.open("w") as err:
            child = subprocess.Popen(command, stdout=out, stderr=err)
            hung = wait(child, seeds)
        played = seeds.read_text().split()
        if not hung and child.returncode == 0:
            print(f"{name}: {len(played)} seeds, nothing found", flush=True)
            return True
        last = played[-1] if played else first
        print(errors.read_text()[-4000:])
    ending = f"no answer for {HANGS_AFTER:.0f} s" if hung else f"exit status {child.returncode}"
    print(f"{name}: {ending} at seed {last}. To see it again: python -m attack {name} --seed {last}", flush=True)
    return False


def wait(child: "subprocess.Popen[bytes]", seeds: Path) -> bool:
    """Waits for the child; kills it, and returns True, if it hangs."""
    written, since = -1, time.monotonic()
    while child.poll() is None:
        time.sleep(0.2)
        size = seeds.stat().st_size
        if size != written:
            written, since = size, time.monotonic()
        elif time.monotonic() - since > HANGS_AFTER:
            child.kill()
            child.wait()
            return True
    return False


if __name__ == "__main__":
    sys.exit(main())
