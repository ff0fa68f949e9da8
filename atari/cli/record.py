"""`atari record`: policies play a game to a replay, and videos are rendered from it."""

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium

from atari.base import durable
from atari.base.program import ctrl_c_as_event, removed_at_ctrl_c
from atari.base.progress import ProgressBar
from atari.cli.arguments import GAME_HELP, Commands, add_command, add_rom
from atari.cli.multiplayer import is_match, make_match, match_task
from atari.cli.policies import PolicySession, find_played, games_of, replay_of
from atari.cli.printing import print_json
from atari.cli.video_flags import VideoFlags, add_video_flags
from atari.games.game import Game
from atari.learning import load_policy
from atari.learning.evaluation.played import has_no_needs
from atari.learning.evaluation.protocols import MAX_EPISODES
from atari.play.multiplayer_session import MultiplayerSession
from atari.recording import RecordReplay, Replay
from atari.recording.replay.file_format import SUFFIX, is_replay
from atari.recording.video.formats import FORMATS, is_picture
from atari.recording.video.writer import frame_rate
from atari.registry.making import make_found
from atari.task import Task
from atari.task.arguments import add_task, given_options, read_game, show_task, task_of
from atari.task.parser import number, seed
from atari.task.task import look_up

Play = Callable[[Path], bool]
"""Plays games to a replay; False if it was interrupted."""

_PRESET, _STEPS = "dqn2015", 1000
"""The preset and the number of steps that a random agent plays without `--policy`."""


def register(commands: Commands) -> None:
    """Add `atari record`."""
    parser = add_command(commands, "record", _record, "let a policy play a game, and record a video or a replay")
    parser.add_argument("game", metavar="GAME", help=f"{GAME_HELP}; with --players also a name of PettingZoo's")
    parser.add_argument(
        "--policy",
        action="append",
        metavar="POLICY",
        help="random, noop, MODULE:FUNCTION (called with observations (n, ...), returns n actions), a replay, such "
        "as game.a26r, a run folder of `atari train`, an SB3 zip, a TorchScript or ONNX file; with --players, one for "
        f"each player, but no replay (default: random; for one player it plays {_STEPS} steps, and preset {_PRESET} "
        "unless GAME is an ID or a task, or an option of the task is given)",
    )
    add_rom(parser)
    length = parser.add_mutually_exclusive_group()
    length.add_argument(
        "--seconds",
        type=number(float, 0.1),
        metavar="S",
        help="seconds of play at the console's speed, all games together; not of a policy that plays whole games",
    )
    length.add_argument(
        "--episodes",
        type=number(int, 1, MAX_EPISODES),
        metavar="N",
        help="number of games (default: 1, if there is a --policy)",
    )
    length.add_argument("--steps", type=number(int, 1), metavar="N", help="steps of a random, noop or function policy")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of game and policy (default: 0)")
    endings = ", ".join((*FORMATS, SUFFIX))
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        action="append",
        metavar="FILE",
        help=f"a video, a picture (.png) or a replay, by its ending ({endings}), an existing file is replaced; may be "
        "repeated (default: videos/GAME-SEED.mp4)",
    )
    parser.add_argument("--no-video", action="store_true", help="play, print the scores, and write nothing")
    parser.add_argument(
        "--best", action="store_true", help="videos show the game with the highest score alone; a replay has all games"
    )
    add_video_flags(parser)
    add_task(parser)


def _record(args: argparse.Namespace) -> int:
    if args.no_video and args.output:
        raise ValueError("--no-video writes nothing; leave it or --output out")
    policies = args.policy or ["random"]
    match = is_match(args)
    if len(policies) > 1 and not match:
        raise ValueError("a second --policy needs --players; see `atari record --help`")
    recorded = not match and is_replay(policies[0])
    task, play = _match(args, policies) if match else _alone(args, policies[0])
    if show_task(args, task):
        return 0
    stem = Path(policies[0]).stem if Path(policies[0]).exists() and not match else str(args.seed)
    files = [] if args.no_video else args.output or [Path("videos", f"{task.game}-{stem}.mp4")]
    outputs = _Outputs(files, VideoFlags(args, files), args.best)
    if args.best and not outputs.videos:
        raise ValueError("--best is for videos and pictures, and a replay has all games; leave it out")
    if isinstance(args.frame, int) and (args.best or (recorded and args.seconds is not None)):
        raise ValueError(f"--frame {args.frame} is a frame of all games; leave --best and --seconds out")
    if recorded and outputs.replays:
        raise ValueError("a replay of a replay is its copy; name a video with -o")
    try:
        outputs.check(task.definition)
    except gymnasium.error.DependencyNotInstalled as error:
        raise gymnasium.error.DependencyNotInstalled(f"{error}; or play without a video: --no-video") from None
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(policies[0]) if recorded else next(iter(outputs.replays), Path(folder, "games.a26r"))
        done = play(path)
        replay = Replay.load(path, game=task.definition, rom=args.rom)
        filmed = outputs.write(replay, args.seconds if recorded else None)
    result = {
        "game": task.game,
        **({"players": task.players, "mode": task.mode, "policies": policies} if match else {"policy": policies[0]}),
        **({} if recorded else {"seed": args.seed}),
        "frames": filmed if recorded else replay.frames_total,
        "scores": _scores(replay, filmed if recorded and args.seconds is not None else None),
        "elapsed_seconds": time.perf_counter() - start,
        "files": [file.resolve() for file in files],
    }
    if not done:
        kept = f"; what was recorded is in {outputs}" if files else ""
        raise KeyboardInterrupt(f"after {result['frames']:,} frames{kept}")
    print_json(result) if args.json else print(_summary(" and ".join(policies), result))
    return 0


def _scores(replay: Replay, stop: int | None) -> list[Any]:
    """The scores of the games of a replay, up to frame `stop`; None is the end."""
    if stop is None:
        return [episode.scores or episode.score for episode in replay.episodes]
    games: dict[int, list[int]] = {}
    for frame in replay.frames(0, stop):
        games[frame.episode] = [a + b for a, b in zip(games.get(frame.episode, [0] * 9), frame.rewards, strict=False)]
    return [game if len(game) > 1 else game[0] for game in games.values()]


def _alone(args: argparse.Namespace, policy: str) -> tuple[Task, Play]:
    if is_replay(policy):
        others = {"steps", "episodes", "seed"} & getattr(args, "flags", set())
        if others or (args.best and args.seconds is not None):
            raise ValueError(
                "a replay is filmed whole, up to --seconds, or its --best game; leave --steps, --episodes and --seed "
                "out"
            )
        return replay_of(args, policy).task, lambda path: True
    loaded = load_policy(policy)
    if not Path(policy).exists() and has_no_needs(loaded):
        found = look_up(read_game(args.game))
        if args.policy is None and (args.seconds, args.episodes, args.steps) == (None, None, None):
            args.steps = _STEPS
        if args.policy is None and args.preset is None and found.bare and not given_options(args):
            args.preset = _PRESET
        task = task_of(args, found)
        if task.continuous:
            raise ValueError("continuous=True has no numbered actions, and a policy chooses one; leave it out")

        def play(path: Path) -> bool:
            env = RecordReplay(make_found(found, task, {"rom": args.rom}), path)
            return _play(args, PolicySession(env, task, loaded, args.seed))

        return task, play
    (game,) = find_played(args, [args.game], loaded)
    task, player = games_of(loaded, game)
    for option in ("seconds", "steps", "rom"):
        if getattr(args, option) is not None:
            raise ValueError(f"{policy} plays whole games, with the ROM that is found; leave --{option} out")
    seeds = range(args.seed, args.seed + (args.episodes or 1))
    return task, lambda path: bool(player.record(seeds, path))


def _match(args: argparse.Namespace, names: list[str]) -> tuple[Task, Play]:
    if args.steps is not None:
        raise ValueError("--steps is for one player; give --seconds or --episodes")
    task = match_task(args)
    return task, lambda path: _play(args, make_match(args, task, "--policy", names)(replay=path))


def _play(args: argparse.Namespace, session: PolicySession | MultiplayerSession) -> bool:
    """Play and close a session, and return False after Ctrl-C."""
    ends, games, steps = _Ends(args, session.game), 0, 0
    with closing(session), ctrl_c_as_event() as interrupted:
        while not ends(games, session.frames, steps):
            if interrupted.is_set():
                return False
            if session.over:
                session.new_game()
            session.play()
            steps += 1
            games += session.over
    return True


class _Ends:
    """The end of a recording; shows a progress bar on a terminal, else a line for each tenth of the steps."""

    def __init__(self, args: argparse.Namespace, game: Game) -> None:
        self._steps = args.steps or math.inf
        self._frames = math.inf if args.seconds is None else math.ceil(args.seconds * frame_rate(game))
        self._games = (args.episodes or 1) if args.steps is None and args.seconds is None else math.inf
        total = args.steps or (None if args.seconds is None else self._frames)
        self._bar = ProgressBar(unit=" steps" if args.steps else " frames", total=total, disable=None)
        self._start, self._next = time.perf_counter(), math.ceil((args.steps or 0) / 10)

    def __call__(self, games: int, frames: int, steps: int) -> bool:
        self._bar.update((frames if self._steps == math.inf else steps) - self._bar.n)
        if self._bar.disable and 0 < self._next <= steps < self._steps:
            self._next += math.ceil(self._steps / 10)
            speed = steps / (time.perf_counter() - self._start)
            print(f"{steps:,} of {self._steps:,} steps, {speed:,.0f} steps/s", file=sys.stderr)
        return steps >= self._steps or frames >= self._frames or games >= self._games


@dataclass(frozen=True)
class _Outputs:
    """The replays, videos and pictures that a command writes.

    Attributes:
        files: the files; their suffixes decide their formats.
        flags: how videos and pictures look.
        best: whether they show only the game with the highest score.
    """

    files: list[Path]
    flags: VideoFlags
    best: bool

    @property
    def replays(self) -> list[Path]:
        return [path for path in self.files if path.suffix.lower() == SUFFIX]

    @property
    def videos(self) -> list[Path]:
        return [path for path in self.files if path.suffix.lower() != SUFFIX]

    def check(self, game: Game) -> None:
        """Check the files before the games, which may take hours.

        Raises:
            TypeError, ValueError, OSError, gymnasium.error.DependencyNotInstalled: see `VideoWriter`.
        """
        endings = (*FORMATS, SUFFIX)
        for path in self.files:
            if path.suffix.lower() not in endings:
                raise ValueError(f"-o is a file that ends in one of {', '.join(endings)}, got {str(path)!r}")
        for path in self.videos:
            self.flags.check(path, game)

    def write(self, replay: Replay, seconds: float | None = None) -> int:
        """Write all files except the loaded replay itself, and return the number of frames of a video.

        Args:
            replay: the replay of the games.
            seconds: the length of the videos; None means the whole replay.
        """
        for path in self.replays:
            if path != replay.path:
                path.parent.mkdir(parents=True, exist_ok=True)
                durable.write_file(path, replay.path.read_bytes())
        frames, part = replay.frames_total, dict[str, Any]()
        if self.best:
            part = {"episode": "best"}
            frames = replay.episodes[replay.best_episode].frames
        elif seconds is not None:
            frames = min(frames, math.ceil(seconds * frame_rate(replay.game)))
            part = {"stop": frames}
        for path in sorted(self.videos, key=is_picture):  # pictures last: their frame may be after the end
            bar = ProgressBar(unit=" frames", total=frames, disable=is_picture(path) or None)
            with bar, removed_at_ctrl_c(path):
                replay.render(path, **self.flags.options(path), **part, progress=bar.update)
        return frames

    def __str__(self) -> str:
        return " and ".join(str(path.resolve()) for path in self.files)


def _summary(policies: str, result: dict[str, Any]) -> str:
    seconds = result["elapsed_seconds"]
    scores = (" : ".join(map(str, one)) if isinstance(one, list) else f"{one:,}" for one in result["scores"])
    return "\n".join(
        [
            f"  policy  {policies}" + (f", seed {result['seed']}" if "seed" in result else ""),
            f"  played  {result['frames']:,} frames in {seconds:.1f} s, {result['frames'] / seconds:,.0f} frames/s, "
            "writing included",
            f"  scores  {', '.join(scores)}",
            *(f"  file    {path}" for path in result["files"]),
        ]
    )
