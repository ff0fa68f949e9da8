"""`atari replay`: show, verify and render replays."""

import argparse
import json
import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from atari.base.program import removed_at_ctrl_c
from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.printing import print_json, print_table, printed_warnings
from atari.cli.video_flags import VideoFlags, add_video_flags, best_or_number
from atari.cores import CORES
from atari.games.game import Game
from atari.recording import Replay
from atari.recording.replay.file_format import is_replay
from atari.recording.video.formats import FORMATS, is_picture
from atari.recording.video.writer import frame_rate
from atari.task.description import summary
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari replay`."""
    group = commands.add_parser(
        "replay",
        help="show, verify and render replays",
        description="Replays (.a26r) hold the actions of a game, about 2 kB a minute, and reproduce it exactly.",
        epilog="`atari play`, `atari record -o game.a26r` and atari.recording.RecordReplay write replays.",
    )
    subcommands = group.add_subparsers(metavar="COMMAND", required=True)
    parser = add_command(subcommands, "show", _show, "show a replay's header and its episodes")
    parser.add_argument("file", type=Path, metavar="FILE")
    parser = add_command(
        subcommands,
        "verify",
        _verify,
        "play replays again and compare them with their recording (exit code 1: different)",
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.add_argument("--core", choices=list(CORES), default="native", help="the core to play on (default: native)")
    parser = add_command(subcommands, "render", _render, "write a video of a replay, or of several side by side")
    parser.add_argument(
        "sources",
        nargs="+",
        metavar="SOURCE",
        help="a replay; a run folder or another policy, as `atari watch` takes it, plays one game: that of its "
        "training, or of the first SOURCE. Several are shown side by side with names, scores and lives, and the sound "
        "of the first; where one ends, its last frame stays",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"the video ({', '.join(FORMATS)}), or a picture (.png), replaced if there (default for a single "
        "replay: its name with the ending .mp4)",
    )
    parser.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="seed of the games of policies, below 2**32 (default: 0)"
    )
    parser.add_argument(
        "--start",
        type=best_or_number,
        default=0,
        metavar="FRAME",
        help="the first frame (default: 0), or best, the --seconds with the most points",
    )
    last = parser.add_mutually_exclusive_group()
    last.add_argument("--stop", type=number(int, 1), metavar="FRAME", help="the frame after the last (default: all)")
    last.add_argument("--seconds", type=number(float, 0.1), metavar="S", help="the length at the console's speed")
    parser.add_argument(
        "--episode",
        type=best_or_number,
        metavar="N",
        help="show one episode alone: its number, as `atari replay show` prints it, or best; of the options above only "
        "with --start best --seconds S, the best part of the episode",
    )
    add_video_flags(parser)


def _show(args: argparse.Namespace) -> int:
    replay = _load(args.file)
    episodes, rewound = replay.episodes, replay.frames_rewound
    if args.json:
        facts = {
            "complete": replay.complete,
            "frames": replay.frames_total,
            "frames_rewound": rewound,
            "steps": replay.steps,
            "core_seeds": replay.seeds,
            "switched_on": replay.switched_on,
            "episodes": episodes,
        }
        task = {} if replay.players > 1 else {"task": json.loads(replay.header["task"])}
        print_json({**replay.header, **task, **facts})
        return 0
    rate = float(frame_rate(replay.game))
    options = ", ".join(f"{name}={value!r}" for name, value in replay.options.items() if value is not None)
    seeds = ", ".join(map(str, replay.seeds))
    if seeds and replay.players == 1:
        seeds += " (of the core, which a reset draws from its own seed)"
    print(f"{args.file}: {replay.game.title}")
    for name, fact in {
        "length": f"{replay.frames_total:,} frames, {_time(replay.frames_total / rate)}, "
        + (f"{replay.steps:,} steps, " if replay.steps else "")
        + f"{args.file.stat().st_size:,} bytes"
        + (f", {rewound:,} frames of it played and then rewound" if rewound else "")
        + ("" if replay.complete else ", cut while it was recorded"),
        "recorded": f"{replay.header.get('source')} on core {replay.header.get('core')!r}, "
        f"atari-envs {replay.header.get('package')}",
        **({"options": options} if replay.players > 1 else {"task": summary(replay.task)}),
        **({"changed": f"by {', '.join(on)}, switched on during the game"} if (on := replay.switched_on) else {}),
        "seeds": seeds or "none: it begins with a snapshot",
        "ROM": f"MD5 {replay.header.get('rom')}",
    }.items():
        print(f"  {name:8}  {fact}")
    rows: list[tuple[object, ...]] = [("  episode", "frames", "time", "score", "end")]
    for index, episode in enumerate(episodes):
        score = episode.score if episode.scores is None else ", ".join(map(str, episode.scores))
        rows.append((f"  {index}", episode.frames, _time(episode.frames / rate), score, episode.end))
    print_table(rows)
    return 0


def _verify(args: argparse.Namespace) -> int:
    results: list[dict[str, Any]] = []
    for file in args.files:
        replay = _load(file)
        with ProgressBar(total=replay.frames_total, unit=" frames", disable=None, leave=False) as bar:
            result = replay.verify(args.core, progress=bar.update)
        results.append({"file": file, "complete": replay.complete, "equal": bool(result), **asdict(result)})
        if not args.json:
            print(f"{file}: {result.divergence or 'equal'}, {result.frames:,} frames on core {args.core!r}")
    if args.json:
        print_json(results)
    return 0 if all(result["equal"] for result in results) else 1


def _render(args: argparse.Namespace) -> int:
    sources: list[str] = args.sources
    recorded = [is_replay(source) for source in sources]
    if args.output is None and recorded != [True]:
        raise ValueError(f"the video of {' and '.join(sources)} needs a name: add -o FILE, such as -o film.mp4")
    output = args.output or Path(sources[0]).with_suffix(".mp4")
    if all(recorded) and "seed" in getattr(args, "flags", ()):
        raise ValueError("--seed is for policies, and what was played is in a replay; leave it out")
    flags = VideoFlags(args, [output])
    with tempfile.TemporaryDirectory() as folder:
        if all(recorded):
            replays = [_load(Path(source)) for source in sources]
        else:
            replays = _played(sources, args.seed, Path(folder), lambda game: flags.check(output, game))
        shown, part = _write(args, replays, output, flags.options(output))
    result: dict[str, Any] = {"file": sources[0]} if len(sources) == 1 else {"files": sources}
    result |= {"frames": shown, **part, ("picture" if is_picture(output) else "video"): output.resolve()}
    if args.json:
        print_json(result)
        return 0
    if is_picture(output):
        what = f"frame {part['frame']:,}" if isinstance(part["frame"], int) else "a picture"
    else:
        what = f"{shown:,} frames" + " of the game" * (output.suffix.lower() == ".gif")  # a GIF drops some of them
        what += f", from frame {part['start']:,} on," if part else ""
    print(f"{what} in {output.resolve()}")
    return 0


def _write(
    args: argparse.Namespace, replays: list[Replay], output: Path, options: dict[str, Any]
) -> tuple[int, dict[str, Any]]:
    """Write the video or the picture; return the number of its frames, and the frame or the start that was found."""
    first, *beside = replays
    part = _part(args, replays)
    frames = max(_length(replay, part) for replay in replays)
    if not frames:
        raise ValueError(f"there are no frames to render: the replay has {first.frames_total:,} frames")
    picture = is_picture(output)
    if options.get("frame") == "best" and not beside:
        options["frame"], part = first.best_frame(**part), {}
    with ProgressBar(total=frames, unit=" frames", disable=picture or None) as bar, removed_at_ctrl_c(output):
        first.render(output, **options, **part, beside=beside, progress=bar.update)
    if picture:
        return 1, {"frame": options["frame"]}
    return frames, {"start": part["start"]} if args.start == "best" else {}


def _played(sources: list[str], seed: int, folder: Path, check: Callable[[Game], None]) -> list[Replay]:
    """The replays, and the games of the policies among them, which are played to `folder` after `check`."""
    from atari.cli.policies import PolicyGame  # here, because other commands of replays need no policies

    found: list[Replay | PolicyGame] = []
    game: Game | None = None
    for source in sources:
        named = None if game is None else str(game.file or game.id)
        found.append(_load(Path(source)) if is_replay(source) else PolicyGame.load(source, named))
        game = game or (first.game if isinstance(first := found[0], Replay) else first.task.definition)
        check(game)
    replays: list[Replay] = []
    for index, one in enumerate(found):
        replay = one if isinstance(one, Replay) else one.play(folder / f"{index}.a26r", seed)
        if not isinstance(one, Replay):
            print(f"{one.source}: seed {seed}, score {replay.episodes[0].score:,}", file=sys.stderr, flush=True)
        replays.append(replay)
    return replays


def _part(args: argparse.Namespace, replays: list[Replay]) -> dict[str, Any]:
    """The part of each replay that the arguments name, as `Replay.render` takes it."""
    first = replays[0]
    length = None if args.seconds is None else math.ceil(args.seconds * frame_rate(first.game))
    if args.start == "best" and len(replays) > 1:
        raise ValueError("--start best is a part of one replay; name one, or give --start a number")
    if args.episode is not None:
        for replay in replays:
            if args.episode != "best" and args.episode >= (count := len(replay.episodes)):
                raise ValueError(
                    f"{replay.path} has no episode {args.episode}; it has {count}, numbered from 0, which "
                    "`atari replay show` lists"
                )
        if args.start == "best" and length is not None:
            frames = min(length, _length(first, {"episode": args.episode}))
            start = first.best_start(frames, episode=args.episode)
            return {"start": start, "stop": start + frames}
        if args.start or args.stop is not None or length is not None:
            raise ValueError(
                "--episode shows a whole episode, or with --start best --seconds S the best part of it; leave --start, "
                "--stop and --seconds out"
            )
        return {"episode": args.episode}
    start = args.start
    if start == "best":
        if length is None:
            raise ValueError("--start best needs --seconds, the length of the part")
        start = first.best_start(max(min(length, first.frames_total), 1))
    return {"start": start, "stop": start + length if length else args.stop}


def _length(replay: Replay, part: dict[str, Any]) -> int:
    """The number of frames in a part of a replay."""
    episode = part.get("episode")
    if episode is not None:
        return replay.episodes[replay.best_episode if episode == "best" else episode].frames
    return max(min(part["stop"] or replay.frames_total, replay.frames_total) - part["start"], 0)


def _load(file: Path) -> Replay:
    with printed_warnings():
        return Replay.load(file)


def _time(seconds: float) -> str:
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)}:{rest:04.1f}"
