"""Frames of a replay: what a call of the core leaves, and where it differs from the hashes in the file."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from atari.recording.replay import file_format
from atari.recording.replay.events import Kind
from atari.recording.replay.file_format import FRAMES_PER_FULL_HASH
from atari.recording.replay.players import actions_of
from atari.recording.replay.results import Frame
from atari.recording.replay.runner import Call, ReplayRunner


def frames_of(calls: Iterable[tuple[ReplayRunner, Call]]) -> Iterator[Frame]:
    """The frames of calls. Where a game ends within a step, a call that plays no frame ends the step."""
    held: Frame | None = None
    for runner, call in calls:
        if call.played:
            if held is not None:
                yield held
            held = _frame(runner, call)
        elif held is not None and (call.event.ends_step or call.event.kind == Kind.STEP):
            held = replace(held, ends_step=True)
    if held is not None:
        yield held


def _frame(runner: ReplayRunner, call: Call) -> Frame:
    core, (kind, numbers, floats, ends_step) = runner.core, call.event
    several = kind == Kind.ACTIONS
    actions = actions_of(numbers[0], core.players) if several else [numbers[0]]
    rewards = call.reward if several else [call.reward]
    lives = core.player_lives if several else [core.lives]
    return Frame(
        index=runner.frame - 1,
        episode=runner.episode,
        action=actions[0],
        strength=floats[0] if floats else 1.0,
        ends_step=ends_step,
        reward=rewards[0],
        score=runner.score[0] if several else runner.score,
        scores=tuple(runner.score) if several else (runner.score,),
        lives=lives[0],
        terminated=core.game_over,
        truncated=core.truncated,
        ram=core.ram(),
        screen=core.screen_rgb(),
        audio=core.audio(),
        actions=tuple(actions),
        rewards=tuple(rewards),
        all_lives=tuple(lives),
    )


def difference(runner: ReplayRunner, play: file_format.PlayChunk) -> str:
    """Return what differs between the last frame and the hashes in the file, or ""."""
    place = runner.frame - play.first - 1
    if place >= len(play.short_hashes):
        return "that the game goes on"
    if file_format.short_hash(runner.core) != play.short_hashes[place]:
        return "RAM"
    if runner.frame % FRAMES_PER_FULL_HASH == 0:
        number = runner.frame // FRAMES_PER_FULL_HASH - play.first // FRAMES_PER_FULL_HASH - 1
        if file_format.full_hash(runner.core, runner.score) != play.full_hashes[number]:
            return "RAM, screen, reward, lives or end"
    return ""
