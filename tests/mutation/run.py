"""Runs the tests that concern a file on mutants of it; `scripts/mutants` has the package and starts this file.

The mutants are drawn by a seed: as many of each part of `PARTS`, the kinds of change in turn. A mutant that does not
compile is replaced by the next one. `tests/support/tests_for.py` names the tests of a file. A mutant is killed if one of them
fails or takes too long.
"""

import argparse
import json
import math
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import cycle, islice, zip_longest
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "support")]

from mutate import KINDS, Mutant, mutants  # noqa: E402
from tests_for import runs  # noqa: E402

PARTS = {
    "options": ("atari/vector/options.py", "atari/task/*.py", "atari/base/validation.py", "atari/registry/making.py"),
    "episode": ("atari/emulator/vector/*.cpp",),
    "wrappers": ("wrappers/*.py",),
    "jit": ("atari/emulator/fast/jit/*.cpp",),
    "memory": ("atari/emulator/memory/*.cpp", "atari/learning/memory/*.py"),
    "rules": ("atari/games/rules.py", "atari/games/compiler.py", "atari/emulator/ale/**/*.cpp"),
}
"""The parts of the package whose files are changed."""

LONGEST_TEST = 240
"""Seconds that a test may take, on a busy machine too; then it counts as failed. The mutant may not end."""
LONGEST_RUN = 1800
"""Seconds that a run of tests may take."""


def candidates(tree: Path, part: str, seeds: Sequence[int]) -> Iterator[Mutant]:
    """All mutants of a part in the random orders of some seeds, which take turns, the kinds of change in turn."""
    files = sorted(file for pattern in PARTS[part] for file in tree.glob(pattern))
    found = [each for file in files for each in mutants(file.relative_to(tree).as_posix(), file.read_text())]
    orders = [_order(found, random.Random(f"{seed} {part}")) for seed in seeds]
    yield from dict.fromkeys(each for turn in zip(*orders, strict=True) for each in turn)


def _order(found: Sequence[Mutant], rng: random.Random) -> list[Mutant]:
    shuffled = rng.sample(found, len(found))
    by_kind = [[each for each in shuffled if each.kind == kind] for kind in KINDS]
    return [each for turn in zip_longest(*by_kind) for each in turn if each is not None]


class Tests:
    """The tests of a tree. Test files that have killed a mutant run before the others: they find most of the next ones."""

    def __init__(self, tree: Path) -> None:
        self.tree = tree
        self.killers: list[str] = []
        self.passed: set[str] = set()
        self.is_built = True

    def build(self) -> bool:
        """Build the C++ of the tree as it stands; whether that was possible."""
        done = subprocess.run([str(self.tree / "scripts" / "dev")], capture_output=True, cwd=self.tree)
        self.is_built = done.returncode == 0
        return self.is_built

    def check(self, file: str) -> None:
        """Run the tests of an unchanged file, once for each set of tests.

        Raises:
            SystemExit: one fails, so it would kill every mutant.
        """
        for arguments in runs(file):
            if str(arguments) not in self.passed:
                if not self.is_built:
                    self.build()
                by = self.first_failure(arguments)
                if by:
                    sys.exit(f"scripts/mutants: {by} fails without a mutant")
                self.passed.add(str(arguments))

    def killer(self, file: str) -> str | None:
        """The first failing test of a changed file, "(no end)" if the tests do not end, or None."""
        found = runs(file)
        tests = [name for arguments in found if "-k" not in arguments for name in arguments]
        likely = [each for each in self.killers if any(each == test or each.startswith(f"{test}/") for test in tests)]
        for arguments in [*([likely[:3]] if likely else []), *found]:
            by = self.first_failure(arguments)
            if by:
                name = by.removeprefix("FAILED ").removeprefix("ERROR ").partition("::")[0]
                if name.startswith("tests/"):
                    self.killers = [name, *(each for each in self.killers if each != name)]
                return by
        return None

    def first_failure(self, arguments: list[str]) -> str | None:
        """Run pytest until a test fails; its name, or None."""
        environment = {**os.environ, "PYTHONSAFEPATH": "1", "SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy"}
        command = [str(self.tree / ".venv-dev" / "bin" / "pytest"), "-x", "-q", "-m", "not peers", "--tb=no", "-n", "2"]
        command += ["-o", f"faulthandler_timeout={LONGEST_TEST}", "-o", "faulthandler_exit_on_timeout=true"]
        command += ["--max-worker-restart", "0", "--dist", "loadfile", "-p", "no:cacheprovider", *arguments]
        # A session of its own, so that the processes of the tests end with it.
        process = subprocess.Popen(
            command, cwd=self.tree, env=environment, text=True, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            output, _ = process.communicate(timeout=LONGEST_RUN)
        except subprocess.TimeoutExpired:
            return "(no end)"
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        if process.returncode in (0, 5):  # 5: no test was selected
            return None
        failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return failed[0].split(" - ")[0] if failed else "(a crash)"


def test(tests: Tests, mutant: Mutant) -> dict[str, object] | None:
    """Applies a mutant, tests it and takes it back; the result, or None if it does not compile."""
    file = tests.tree / mutant.file
    text = file.read_text()
    tests.check(mutant.file)
    started = time.monotonic()
    try:
        file.write_text(mutant.apply(text))
        compiled = file.suffix != ".py"
        if (compiled or not tests.is_built) and not tests.build():
            return None
        by = tests.killer(mutant.file)
    finally:
        file.write_text(text)
        tests.is_built = tests.is_built and not compiled  # the next build has the file as it was
    seconds = round(time.monotonic() - started)
    return {"kind": mutant.kind, "killed_by": by, "seconds": seconds, "mutant": mutant.describe(text)}


def report(results: list[dict[str, object]]) -> str:
    """The share killed, by part and in all, and the survivors."""
    counts, killed = Counter(each["part"] for each in results), Counter(e["part"] for e in results if e["killed_by"])
    lines = [f"{part}: {killed[part]} of {counts[part]} killed" for part in PARTS if counts[part]]
    share = sum(killed.values()) / max(len(results), 1)
    lines.append(f"in all: {sum(killed.values())} of {len(results)} killed, {share:.0%}; the survivors:")
    return "\n".join(lines + [f"  {each['mutant']}" for each in results if not each["killed_by"]])


def main() -> None:
    """Test the mutants and print the report."""
    parser = argparse.ArgumentParser(prog="scripts/mutants", description="Test the tests by mutants of the sources.")
    parser.add_argument("tree", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--count", type=int, default=60, help="how many mutants (default 60)")
    parser.add_argument("--seed", type=int, nargs="+", default=[0], help="which ones (default 0)")
    parser.add_argument("--minutes", type=float, default=math.inf, help="draw no mutant after this time")
    parser.add_argument("--part", choices=PARTS, action="append", help="only of this part")
    parser.add_argument("--out", type=Path, help="a JSON file of the results, which goes on if it exists")
    parser.add_argument("--list", action="store_true", help="print the mutants and test none")
    options = parser.parse_args()
    parts = options.part or list(PARTS)
    drawn = {part: candidates(options.tree, part, options.seed) for part in parts}
    if options.list:
        for mutant in (mutant for part in parts for mutant in islice(drawn[part], options.count // len(parts))):
            print(mutant.describe((options.tree / mutant.file).read_text()))
        return
    goes_on = options.out and options.out.exists()
    results: list[dict[str, object]] = json.loads(options.out.read_text()) if goes_on else []
    known = {each["mutant"] for each in results}
    tests, started = Tests(options.tree), time.monotonic()
    # The parts in turn, so that a run that ends early has as many mutants of each.
    for part in islice(cycle(parts), len(results), options.count):
        if time.monotonic() - started > 60 * options.minutes:
            break
        new = (each for each in drawn[part] if each.describe((options.tree / each.file).read_text()) not in known)
        result = next(filter(None, (test(tests, mutant) for mutant in new)))
        results.append({"part": part, **result})
        print(f"{result['killed_by'] or 'SURVIVED'} [{result['seconds']} s] {result['mutant']}", flush=True)
        if options.out:
            options.out.write_text(json.dumps(results, indent=1) + "\n")
    if results:
        print(report(results))


if __name__ == "__main__":
    main()
