"""`atari record`: a policy plays a game, and a video or a replay of it is written."""

import argparse
import math
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

import atari
from atari._interrupt import ctrl_c_as_event
from atari.cli.arguments import GAME_HELP, add_command, add_overlay, add_rom, find_function, find_game, number
from atari.cli.multiplayer import make_match, multiplayer
from atari.cli.observers import ScoreCounter, VideoObserver
from atari.cli.output import print_json
from atari.env import AtariEnv
from atari.games.game import Game
from atari.recording import FORMATS, RecordReplay, Replay, VideoWriter, frame_rate
from atari.recording.replay.file_format import SUFFIX
from atari.recording.video.encoder import import_av
from atari.recording.video.formats import has_sound
from atari.recording.video.options import VideoOptions
from atari.recording.video.overlay import Overlay

if TYPE_CHECKING:
    from atari.cli.arguments import Commands

Policy = Callable[[Any], Any]


def register(commands: "Commands") -> None:
    """Add `atari record`."""
    parser = add_command(commands, "record", _record, "let a policy play a game, and record a video or a replay")
    parser.add_argument(
        "game",
        metavar="GAME",
        help=GAME_HELP,
    )
    add_rom(parser)
    parser.add_argument(
        "--policy",
        action="append",
        metavar="POLICY",
        help="random, noop, MODULE:FUNCTION (called with each observation, returns an action), a replay, such as "
        "game.a26, a run folder of `atari train`, an SB3 zip, a TorchScript or ONNX file (default: random); with "
        "--players, one for each player: random, noop, a run folder or MODULE:FUNCTION (called with an observation and "
        "an info)",
    )
    multiplayer(parser)
    parser.add_argument("--preset", metavar="NAME", help="the preprocessing that the policy needs, such as dqn2015")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--episodes", type=number(int, 1), default=1, metavar="N", help="number of games (default: 1)")
    length.add_argument(
        "--seconds", type=number(float, 0.1), metavar="S", help="seconds of play at the console's speed"
    )
    parser.add_argument(
        "--seed", type=number(int, 0), default=0, metavar="N", help="seed of game and policy (default: 0)"
    )
    endings = ", ".join((*FORMATS, ".a26"))
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        action="append",
        metavar="FILE",
        help=f"a video or a replay, by its ending ({endings}), an existing file is replaced; may be repeated "
        "(default: videos/GAME-SEED.mp4)",
    )
    parser.add_argument(
        "--scale", type=number(int, 1), default=2, metavar="N", help="rows of the video a pixel (default: 2)"
    )
    parser.add_argument(
        "--best",
        action="store_true",
        help="videos show the game with the highest score alone; a replay has all games; not with --players",
    )
    add_overlay(parser)
    parser.add_argument("--no-sound", action="store_true", help="write no sound")


def _record(args: argparse.Namespace) -> int:
    if args.players is not None:
        return _record_match(args)
    policies = args.policy or ["random"]
    given = {
        "a second --policy": len(policies) > 1,
        "--mode": args.mode is not None,
        "--difficulty": args.difficulty is not None,
        "--obs": args.obs is not None,
    }
    for option, is_given in given.items():
        if is_given:
            raise ValueError(f"{option} needs --players; see `atari record --help`")
    args.policy = policies[0]
    if args.policy.endswith(SUFFIX):
        return _film_replay(args)
    if Path(args.policy).exists():
        return _film_policy(args)
    _check_endings(args.output or [])
    env = _make(args)
    game = env.unwrapped.game
    outputs = args.output or [Path("videos", f"{game.id}-{args.seed}.mp4")]
    videos = [path for path in outputs if path.suffix.lower() != SUFFIX]
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        if videos and (args.best or args.overlay):  # the games are recorded first, and filmed then
            _check_videos(videos, game, args)
            replays = [path for path in outputs if path not in videos] or [Path(folder, "games.a26")]
            counter, done = _play_and_write(env, args, replays)
            _film(Replay.load(replays[0]), videos, args)
        else:
            counter, done = _play_and_write(env, args, outputs)
    files = [path.resolve() for path in outputs]
    if not done:
        raise KeyboardInterrupt(f"after {counter.frames:,} frames; what was recorded is in {_listed(files)}")
    result = {
        "game": game.id,
        "policy": args.policy,
        "seed": args.seed,
        "frames": counter.frames,
        "scores": counter.scores,
        "elapsed_seconds": time.perf_counter() - start,
        "files": files,
    }
    print_json(result) if args.json else print(_summary(result))
    return 0


def _play_and_write(env: Any, args: argparse.Namespace, outputs: list[Path]) -> tuple[ScoreCounter, bool]:
    """Play the games and write videos and replays of all of them meanwhile; False if play was interrupted."""
    with ExitStack() as stack:
        stack.callback(lambda: env.close())  # late binding: closes the outermost wrapper
        inner = env.unwrapped
        policy = _policy(args.policy, env)
        score_counter = ScoreCounter()
        inner.observers.append(score_counter)
        for path in outputs:
            if path.suffix.lower() == SUFFIX:
                env = RecordReplay(env, path)
            else:
                inner.observers.append(VideoObserver(inner, stack.enter_context(_video(path, inner, args))))
        interrupted = stack.enter_context(ctrl_c_as_event())
        env.action_space.seed(args.seed)
        return score_counter, _play(env, policy, score_counter, args, interrupted)


def _film(replay: Replay, outputs: list[Path], args: argparse.Namespace) -> int:
    """Write videos of a replay, or with --best of its best episode; returns the number of their frames."""
    frames = replay.frames_total
    part: dict[str, Any] = {}
    if args.best:
        best = replay.best_episode
        part, frames = {"episode": best}, replay.episodes[best].frames
    elif args.seconds is not None:
        frames = min(frames, math.ceil(args.seconds * frame_rate(replay.game)))
        part = {"stop": frames}
    options = {"scale": args.scale, "sound": not args.no_sound, "overlay": args.overlay}
    for path in outputs:
        with tqdm(unit=" frames", total=frames, disable=None) as bar:
            replay.render(path, **options, **part, progress=bar.update)
    return frames


def _play(env: Any, policy: Policy, score_counter: ScoreCounter, args: argparse.Namespace, interrupted: Event) -> bool:
    """Play, and return False if play was interrupted."""
    core = env.unwrapped.core
    seconds = args.seconds
    frames = math.inf if seconds is None else math.ceil(seconds * frame_rate(env.unwrapped.game))
    games = 0
    with tqdm(unit=" frames", total=None if seconds is None else frames, disable=None) as bar:
        observation, _ = env.reset(seed=args.seed)
        while score_counter.frames < frames and (seconds is not None or games < args.episodes):
            if interrupted.is_set():
                return False
            observation, _, terminated, truncated, _ = env.step(policy(observation))
            if terminated or truncated:
                games += core.game_over or truncated  # a lost life is not counted
                if seconds is not None or games < args.episodes:
                    observation, _ = env.reset()
            bar.update(score_counter.frames - bar.n)
    return True


def _record_match(args: argparse.Namespace) -> int:
    """Record a game of several players, each of which is a policy."""
    if args.preset is not None:
        raise ValueError("--preset is for one player; the policies of several players see what --obs says")
    if args.best or args.overlay:
        raise ValueError("--best and --overlay are for one player; record a replay, and use `atari replay render`")
    replays = [path for path in args.output or () if path.suffix.lower() == SUFFIX]
    if len(replays) > 1:
        raise ValueError(f"one replay of several players is written at a time, got {_listed(replays)}")
    _check_endings(args.output or [])
    session = make_match(args, "--policy", args.policy or ["random"], replay=replays[0] if replays else None)
    outputs = args.output or [Path("videos", f"{session.game.id}-{args.seed}.mp4")]
    frames = math.inf if args.seconds is None else math.ceil(args.seconds * frame_rate(session.game))
    scores, start = [], time.perf_counter()
    with ExitStack() as stack:
        stack.callback(session.close)
        videos = [stack.enter_context(_open_video(path, session.game, args)) for path in outputs if path not in replays]
        interrupted = stack.enter_context(ctrl_c_as_event())
        bar = stack.enter_context(tqdm(unit=" frames", total=None if args.seconds is None else frames, disable=None))
        while session.frames < frames and not interrupted.is_set():
            session.play()
            for video in videos:
                video.write(session.screen, session.samples if video.sound else None)
            bar.update(1)
            if session.over:
                scores.append(session.scores)
                if args.seconds is None and len(scores) == args.episodes:
                    break
                session.new_game()
    if not scores or not session.over:
        scores.append(session.scores)
    files = [path.resolve() for path in outputs]
    if interrupted.is_set():
        raise KeyboardInterrupt(f"after {session.frames:,} frames; what was recorded is in {_listed(files)}")
    result = {
        "game": session.game.id,
        "players": session.core.players,
        "mode": session.core.mode,
        "policies": args.policy or ["random"],
        "seed": args.seed,
        "frames": session.frames,
        "scores": scores,
        "elapsed_seconds": time.perf_counter() - start,
        "files": files,
    }
    print_json(result) if args.json else print(_match_summary(result))
    return 0


def _film_replay(args: argparse.Namespace) -> int:
    replay = Replay.load(args.policy)
    game = find_game(args.game)
    if replay.game != game:
        raise ValueError(f"{args.policy} is a replay of {replay.game.id}, not of {game.id}")
    outputs = args.output or [Path("videos", f"{game.id}-{Path(args.policy).stem}.mp4")]
    if any(path.suffix.lower() == SUFFIX for path in outputs):
        raise ValueError("a replay of a replay is its copy; name a video with -o")
    if args.best and args.seconds is not None:
        raise ValueError("--best films a whole game of the replay; leave --seconds out")
    frames = _film(replay, outputs, args)
    files = [path.resolve() for path in outputs]
    result = {"game": game.id, "policy": args.policy, "frames": frames, "files": files}
    print_json(result) if args.json else print(f"{frames:,} frames of {args.policy} in {_listed(files)}")
    return 0


def _film_policy(args: argparse.Namespace) -> int:
    """Record whole games of a trained policy, with the observations that it was trained on."""
    if args.seconds is not None or args.preset is not None:
        raise ValueError(f"{args.policy} decides what it sees and plays whole games; leave --seconds and --preset out")
    from atari.learning import load_policy, record_games

    policy, game = load_policy(args.policy), find_game(args.game)
    outputs = args.output or [Path("videos", f"{game.id}-{Path(args.policy).stem}.mp4")]
    _check_endings(outputs)
    seeds = range(args.seed, args.seed + args.episodes)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "games.a26")
        played = record_games(policy, game, getattr(policy, "protocol", "baselines"), seeds, path)
        replays = [output for output in outputs if output.suffix.lower() == SUFFIX]
        for output in replays:
            output.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, output)
        _film(Replay.load(path), [output for output in outputs if output not in replays], args)
    files = [path.resolve() for path in outputs]
    scores = [score for score, _ in played]
    result = {"game": game.id, "policy": args.policy, "seed": args.seed, "scores": scores, "files": files}
    print_json(result) if args.json else print(f"scores {scores}: {_listed(files)}")
    return 0


def _make(args: argparse.Namespace) -> Any:
    options: dict[str, Any] = {"preset": args.preset, "rom": args.rom}
    if args.policy == "noop" and args.preset is None:
        options["full_action_space"] = True  # some games do not use NOOP
    return atari.make(args.game, **options)


def _policy(name: str, env: Any) -> Policy:
    if name == "random":
        return lambda observation: env.action_space.sample()
    if name == "noop":
        meanings = env.unwrapped.get_action_meanings()
        if "NOOP" not in meanings:
            raise ValueError(f"{env.unwrapped.game.id} has no NOOP with this preset; leave --preset out")
        return lambda observation: meanings.index("NOOP")
    if ":" not in name:
        raise ValueError(f"--policy must be random, noop, MODULE:FUNCTION or a replay (.a26), got {name!r}")
    return find_function("--policy", name)


def _check_endings(outputs: list[Path]) -> None:
    endings = (*FORMATS, ".a26")
    for path in outputs:
        if path.suffix.lower() not in endings:
            raise ValueError(f"-o is a file that ends in one of {', '.join(endings)}, got {str(path)!r}")


def _check_videos(videos: list[Path], game: Game, args: argparse.Namespace) -> None:
    """Check before the games are played what `_film` would find wrong after them."""
    shown, rate = Overlay(args.overlay), frame_rate(game)
    lines, size = shown.caption_lines, shown.size(game.screen.shape)
    for path in videos:
        sound = not args.no_sound and has_sound(path)
        options = VideoOptions.check(path, size, rate, scale=args.scale, sound=sound, caption_lines=lines)
        if options.format.container:
            import_av()


def _video(path: Path, env: AtariEnv, args: argparse.Namespace) -> VideoWriter:
    video = _open_video(path, env.game, args)
    if video.sound:
        env.make_sound()
    return video


def _open_video(path: Path, game: Game, args: argparse.Namespace) -> VideoWriter:
    sound = not args.no_sound and has_sound(path)
    return VideoWriter(path, game.screen.shape, frame_rate(game), scale=args.scale, sound=sound)


def _summary(result: dict[str, Any]) -> str:
    scores = result["scores"]
    return "\n".join(
        [
            f"{result['game']}: policy {result['policy']}, seed {result['seed']}",
            f"  played  {result['frames']:,} frames in {result['elapsed_seconds']:.1f} s, writing included",
            f"  scores  {', '.join(f'{score:,}' for score in scores)}",
            *(f"  file    {path}" for path in result["files"]),
        ]
    )


def _match_summary(result: dict[str, Any]) -> str:
    return "\n".join(
        [
            f"{result['game']}: {result['players']} players, mode {result['mode']}, seed {result['seed']}",
            f"  played  {result['frames']:,} frames in {result['elapsed_seconds']:.1f} s, writing included",
            f"  scores  {', '.join(' : '.join(map(str, scores)) for scores in result['scores'])}",
            *(f"  file    {path}" for path in result["files"]),
        ]
    )


def _listed(files: list[Path]) -> str:
    return " and ".join(map(str, files))
