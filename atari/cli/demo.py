"""`atari demo`: a random agent plays a game on the preprocessing of DQN, and a video of it is written.

The agent gets DQN's observations, four 84x84 frames a step. The video shows every emulated frame of the console, with
sound.
"""

import argparse
import math
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any

import gymnasium
from tqdm import tqdm

import atari
from atari._interrupt import ctrl_c_as_event
from atari.cli.arguments import GAME_HELP, add_command, number
from atari.cli.observers import ScoreCounter, VideoObserver
from atari.cli.output import print_json
from atari.games.game import Game
from atari.recording import VideoWriter, frame_rate
from atari.task.description import summary
from atari.task.resolution import is_id

if TYPE_CHECKING:
    from atari.cli.arguments import Commands

_PRESET = "dqn2015"
"""The preset of a game's name alone. An ID is played without one."""


def register(commands: "Commands") -> None:
    """Add `atari demo`."""
    parser = add_command(commands, "demo", _demo, "let a random agent play a game, and write a video of it")
    parser.add_argument("game", metavar="GAME", nargs="?", default="breakout", help=f"{GAME_HELP} (default: breakout)")
    length = parser.add_mutually_exclusive_group()
    length.add_argument(
        "--steps", type=number(int, 1), default=1000, metavar="N", help="steps of the agent (default: 1000)"
    )
    length.add_argument(
        "--seconds", type=number(float, 0.1), metavar="S", help="seconds of play at the console's speed"
    )
    parser.add_argument(
        "--seed", type=number(int, 0), default=0, metavar="N", help="seed of game and agent (default: 0)"
    )
    video = parser.add_mutually_exclusive_group()
    video.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="the video; an existing file is replaced (default: videos/GAME-SEED.mp4)",
    )
    video.add_argument("--no-video", action="store_true", help="write no video")


def _demo(args: argparse.Namespace) -> int:
    task = atari.Task.of(args.game, preset=None if is_id(args.game) else _PRESET)
    game, steps = task.definition, args.steps
    if args.seconds is not None:
        steps = math.ceil(args.seconds * frame_rate(game) * 2 / (sum(task.frames) - 1))
    output = None if args.no_video else args.output or Path("videos", f"{game.id}-{args.seed}.mp4")
    env: Any = task.make()
    with closing(env), ctrl_c_as_event() as interrupted, _open_video(output, game) as video:
        score_counter = ScoreCounter()
        env.unwrapped.observers.append(score_counter)
        if video is not None:
            env.unwrapped.make_sound()
            env.unwrapped.observers.append(VideoObserver(env.unwrapped, video))
        env.action_space.seed(args.seed)
        env.reset(seed=args.seed)
        start = time.perf_counter()
        played = _play(env, steps, interrupted)
        elapsed = time.perf_counter() - start
    if played < steps:
        kept = f"; the video up to there is {output.resolve()}" if output else ""
        raise KeyboardInterrupt(f"after {played:,} of {steps:,} steps{kept}")
    result = {
        "game": game.id,
        "preset": None if is_id(args.game) else _PRESET,
        "task": summary(task),
        "seed": args.seed,
        "steps": steps,
        "frames": score_counter.frames,
        "elapsed_seconds": elapsed,
        "steps_per_second": steps / elapsed,
        "frames_per_second": score_counter.frames / elapsed,
        "scores": score_counter.scores,
        "video": output and output.resolve(),
    }
    print_json(result) if args.json else print(_summary(game, result))
    return 0


def _play(env: gymnasium.Env[Any, Any], steps: int, interrupted: Event) -> int:
    """Play at random and return the number of steps, which is smaller than `steps` if interrupted."""
    for step in _progress(steps):
        if interrupted.is_set():
            return step
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()
    return steps


def _open_video(output: Path | None, game: Game) -> AbstractContextManager[VideoWriter | None]:
    if output is None:
        return nullcontext()
    try:
        return VideoWriter(output, game.screen.shape, frame_rate(game), sound=True)
    except gymnasium.error.DependencyNotInstalled as error:
        raise gymnasium.error.DependencyNotInstalled(f"{error}; or play without a video: --no-video") from None


def _progress(steps: int) -> Iterator[int]:
    """Count the steps, with a progress bar on a terminal, or with a line for each tenth of the steps."""
    plain = not sys.stderr.isatty()
    tenth = math.ceil(steps / 10)
    start = time.perf_counter()
    for step in tqdm(range(steps), unit=" steps", disable=plain):
        if plain and step and step % tenth == 0:
            speed = step / (time.perf_counter() - start)
            print(f"{step:,} of {steps:,} steps, {speed:,.0f} steps/s", file=sys.stderr)
        yield step


def _summary(game: Game, result: dict[str, Any]) -> str:
    scores = result["scores"]
    mean = sum(scores) / len(scores)
    played = f"the preset {result['preset']}" if result["preset"] else result["task"].partition(", as ")[2]
    return "\n".join(
        [
            f"{game.title}: a random agent on {played}, seed {result['seed']}",
            f"  played  {result['steps']:,} steps, {result['frames']:,} frames, in {result['elapsed_seconds']:.1f} s",
            f"  speed   {result['steps_per_second']:,.0f} steps/s, {result['frames_per_second']:,.0f} frames/s"
            + (", writing the video included" if result["video"] else ""),
            f"  games   {len(scores)} begun; score {mean:,.1f} on average, {max(scores):,} at best",
            f"  video   {result['video'] or 'none'}",
        ]
    )
