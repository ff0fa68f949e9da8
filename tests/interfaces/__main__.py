"""Compares the interfaces of other packages with this one, and prints what is missing, by reason.

python -m interfaces                       all peers whose facts are at hand
python -m interfaces gym --archives DIR    Gym from its unpacked archives, DIR/VERSION/gym-VERSION/gym
python -m interfaces gym --archives DIR --write    and keep its facts for the test that needs no network
"""

import argparse
import importlib
import sys
from pathlib import Path

from interfaces.compare import compare
from interfaces.live import NotInstalled
from interfaces.reasons import Table, reasons, tabulate

PEERS = tuple(sorted(path.stem for path in (Path(__file__).parent / "peers").glob("[a-z]*.py")))


def table(peer: str, archives: Path | None = None) -> Table:
    """What of a peer is missing here. A peer is a module of `peers` with `facts`, `OURS` and optionally `NEWEST`."""
    module = importlib.import_module(f"interfaces.peers.{peer}")
    facts = module.facts(archives) if archives else module.facts()
    return tabulate(compare(facts, module.OURS), reasons(peer), facts, getattr(module, "NEWEST", ""))


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="interfaces", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("peers", nargs="*", metavar="PEER", help=f"one of {', '.join(PEERS)} (default: all)")
    parser.add_argument("--archives", type=Path, help="the folder of the unpacked archives")
    parser.add_argument("--write", action="store_true", help="keep the facts of the archives in tests/interfaces/data")
    arguments = parser.parse_args()
    if unknown := set(arguments.peers) - set(PEERS):
        parser.error(f"there is no peer {sorted(unknown)[0]!r}; there are {', '.join(PEERS)}")
    if arguments.write:
        for peer in arguments.peers:
            importlib.import_module(f"interfaces.peers.{peer}").write(arguments.archives)
    fails = False
    for peer in arguments.peers or PEERS:
        try:
            found = table(peer, arguments.archives if peer == "gym" else None)
        except NotInstalled as error:
            print(f"{peer}\n  NOT COMPARED: {error}\n")
            fails = True
            continue
        print(f"{peer}\n{found}\n")
        fails |= found.fails
    return int(fails)


if __name__ == "__main__":
    sys.exit(main())
