"""`atari roms`: list, verify, identify and add ROM files."""

import argparse
import contextlib
import sys
from pathlib import Path

from atari import roms
from atari.base.program import print_error
from atari.cli.arguments import GAME_HELP, Commands, add_command, find_game
from atari.cli.printing import print_json, print_table, print_warning
from atari.games.catalog import games
from atari.roms.importing import ImportReport
from atari.roms.locations import path, unread
from atari.roms.search import Check

_REJECTED_SHOWN = 20  # a folder of all the console's ROM files has thousands of other games


def register(commands: Commands) -> None:
    """Add `atari roms`."""
    group = commands.add_parser(
        "roms",
        help="list, check, identify and add ROM files",
        description="ROM files: ale-py's wheel carries one for every game, so nothing needs to be set up.",
        epilog="They are searched for in the folders that ATARI_ROMS names, in your own, and in ale-py's.",
    )
    subcommands = group.add_subparsers(metavar="COMMAND", required=True)
    add_command(subcommands, "list", _list, "show the file that is used for each game")
    parser = add_command(subcommands, "verify", _verify, "check the files that are used, by size and hashes")
    parser.add_argument("games", nargs="*", metavar="GAME", help=f"{GAME_HELP} (default: all games)")
    parser = add_command(subcommands, "identify", _identify, "say which game a file is, by its content")
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser = add_command(subcommands, "import", _import, "copy the ROM files of known games to your own folder")
    parser.add_argument("source", type=Path, metavar="PATH", help="a folder, an archive (zip, tar, tar.gz) or a file")
    parser = add_command(subcommands, "install", _install, "download the ROM files with AutoROM (extra 'roms')")
    parser.add_argument("--accept-license", action="store_true", help="do not ask; you own a licence to the ROM files")


def _list(args: argparse.Namespace) -> int:
    _warn_of_unread()
    installed = roms.installed()
    files = {game: installed.get(game) for game in games}
    print_json(files) if args.json else print_table((game, file or "missing") for game, file in files.items())
    return 0


def _warn_of_unread() -> None:
    if clause := unread():
        print_warning(clause)


def _verify(args: argparse.Namespace) -> int:
    _warn_of_unread()
    checks: dict[str, Check] = {}
    for name in args.games:
        checks.update(roms.verify(find_game(name, playable=False)))
    if not args.games:
        checks = roms.verify()
    right = sum(check.status == "ok" for check in checks.values())
    if args.json:
        print_json(checks)
    else:
        print_table((check.game, check.status, check.file or "", check.note) for check in checks.values())
        print(f"{right} of {len(checks)} ROM files are right")
    return 0 if right == len(checks) else 1


def _identify(args: argparse.Namespace) -> int:
    found = []
    for file in args.files:
        try:
            found.append(roms.identify(file))
        except (OSError, ValueError) as error:  # a bad file does not hide the other files
            print_error(error)
    if args.json:
        names = ("name", "size", "md5", "sha256", "verdict")
        ids = [{"game": each.game and each.game.id, "nearest": each.nearest and each.nearest.id} for each in found]
        facts = [{name: getattr(each, name) for name in names} for each in found]
        print_json([{**fact, **id_} for fact, id_ in zip(facts, ids, strict=True)])
    else:
        print("".join(f"{each}\n" for each in found), end="")
    return 0 if len(found) == len(args.files) and all(each.game for each in found) else 1


def _import(args: argparse.Namespace) -> int:
    return _report(roms.import_from(args.source), args.json)


def _install(args: argparse.Namespace) -> int:
    # AutoROM prints its prompt to stdout, which is for the result.
    with contextlib.redirect_stdout(sys.stderr):
        report = roms.install(accept_license=args.accept_license)
    return _report(report, args.json)


def _report(report: ImportReport, json: bool) -> int:
    """Print the imported files; the exit code is 1 if no file was imported or present."""
    if json:
        print_json(report)
    else:
        for word, files in (("games imported", report.imported), ("already there", report.present)):
            print(f"{word}: {len(files)}" + (f" ({', '.join(files)})" if files else ""))
        print(f"files not taken: {len(report.rejected)}")
        for sentence in report.rejected[:_REJECTED_SHOWN]:
            print(f"  {sentence}")
        if len(report.rejected) > _REJECTED_SHOWN:
            print(f"  ... and {len(report.rejected) - _REJECTED_SHOWN} more (all with --json)")
        print(f"your folder: {path()}")
    return 0 if report.imported or report.present else 1
