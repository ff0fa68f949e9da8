"""`atari replay`: show, verify and render replays."""

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from atari.base.program import removed_at_ctrl_c
from atari.base.progress import ProgressBar
from atari.base.validation import check_integer
from atari.cli.arguments import Commands, add_command
from atari.cli.printing import print_json, print_table, printed_warnings
from atari.cli.video_flags import VideoFlags, add_video_flags, best_or_number
from atari.cores import CORES
from atari.recording import Replay
from atari.recording.video.formats import FORMATS, is_picture
from atari.recording.video.writer import frame_rate
from atari.task.description import summary
from atari.task.parser import number


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
    parser = add_command(subcommands, "render", _render, "write a video of a replay")
    parser.add_argument("file", type=Path, metavar="FILE")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"the video ({', '.join(FORMATS)}), or a picture (.png), replaced if there (default: FILE with the ending "
        ".mp4)",
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
    replay = _load(args.file)
    output = args.output or args.file.with_suffix(".mp4")
    options = VideoFlags(args, [output]).options(output)
    part, frames = _part(args, replay)
    if not frames:
        raise ValueError(f"there are no frames to render: the replay has {replay.frames_total:,} frames")
    picture = is_picture(output)
    if options.get("frame") == "best":
        options["frame"], part = replay.best_frame(**part), {}
    with ProgressBar(total=frames, unit=" frames", disable=picture or None) as bar, removed_at_ctrl_c(output):
        replay.render(output, **options, **part, progress=bar.update)
    result: dict[str, Any] = {"file": args.file, "frames": 1 if picture else frames}
    if picture:
        shown = "a picture" if options["frame"] is None else f"frame {options['frame']:,}"
        result |= {"frame": options["frame"], "picture": output.resolve()}
    else:
        shown = f"{frames:,} frames" + " of the game" * (output.suffix.lower() == ".gif")  # a GIF drops some of them
        result |= {"video": output.resolve()}
        if args.start == "best":
            shown += f", from frame {part['start']:,} on,"
            result |= {"start": part["start"]}
    print_json(result) if args.json else print(f"{shown} in {output.resolve()}")
    return 0


def _part(args: argparse.Namespace, replay: Replay) -> tuple[dict[str, Any], int]:
    """The part of a replay that the arguments name, as `Replay.render` takes it, and the number of its frames."""
    length = None if args.seconds is None else math.ceil(args.seconds * frame_rate(replay.game))
    if args.episode is not None:
        most = len(replay.episodes) - 1
        best = args.episode == "best"
        number = replay.best_episode if best else check_integer("--episode", args.episode, 0, most)
        played = replay.episodes[number].frames
        if args.start == "best" and length is not None:
            frames = min(length, played)
            start = replay.best_start(frames, episode=number)
            return {"start": start, "stop": start + frames}, frames
        if args.start or args.stop is not None or length is not None:
            raise ValueError(
                "--episode shows a whole episode, or with --start best --seconds S the best part of it; leave --start, "
                "--stop and --seconds out"
            )
        return {"episode": number}, played
    start = args.start
    if start == "best":
        if length is None:
            raise ValueError("--start best needs --seconds, the length of the part")
        start = replay.best_start(max(min(length, replay.frames_total), 1))
    stop = start + length if length else args.stop
    return {"start": start, "stop": stop}, max(min(stop or replay.frames_total, replay.frames_total) - start, 0)


def _load(file: Path) -> Replay:
    with printed_warnings():
        return Replay.load(file)


def _time(seconds: float) -> str:
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)}:{rest:04.1f}"
