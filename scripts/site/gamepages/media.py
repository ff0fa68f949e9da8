"""The media of one game: `render` writes its video and pictures into a folder."""

import random
from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path

import numpy as np
from pictures import Image, mosaic, png, strip

from atari.cores import NativeCore
from atari.games.game import Game
from atari.multiplayer import MultiplayerCore
from atari.recording import Replay, VideoWriter
from atari.task import PRESETS, Task
from atari.web.film import film
from gamepages.facts import FILM, MODES, SCREEN, VIDEO, VIEWS, shown_modes
from gamepages.markup import shape
from gamepages.plays import play_of

SECONDS = 18  # seconds of a video

_HOLD = 4  # frames that a random action is held
_MODE_FRAMES = 240  # frames of random play, from which a mode's picture is chosen
_VIEW_STEPS = 600  # steps of a preset in a play, of which one is shown


def render(game: Game, folder: Path) -> None:
    """Write the media of a game: a video and a film of its play, a screen, its modes, and the presets' observations."""
    play = play_of(game.id)
    if play is not None:
        replay = Replay.load(play.path)
        start, stop = _window([frame.reward for frame in replay.frames()])
        replay.render(folder / VIDEO, start=start, stop=stop)
        (folder / FILM).write_bytes(film_of(replay))
        if game.single_player:
            _write(folder / VIEWS, _views(replay))
        screens = (frame.screen for frame in islice(replay.frames(start, stop), 0, None, 15))
    else:
        screens = iter(_write_random(game, folder / VIDEO)[::15])
    _write(folder / SCREEN, _busiest(screens).repeat(2, axis=1))
    if len(shown_modes(game)) > 1:
        modes = [_mode_screen(game, mode) for mode in shown_modes(game)]
        _write(folder / MODES, mosaic(modes, shape(len(modes))[0]))


def film_of(replay: Replay) -> bytes:
    """The whole replay as a film, for the page that plays it."""
    return film(replay.frames(sound=True), replay.frames_total, replay.game.screen.frame_rate, replay.players)


def _write(path: Path, image: Image) -> None:
    path.write_bytes(png(image))


def _busiest(screens: Iterable[Image]) -> Image:
    """The screen with the most pixels that differ from the one to their left; the first of equals."""
    return max(screens, key=lambda screen: int((screen[:, 1:] != screen[:, :-1]).any(axis=2).sum()))


def _window(rewards: list[int]) -> tuple[int, int]:
    """(start, stop) of the part of a play with the most rewards; the first of equals."""
    length = min(len(rewards), SECONDS * 60)
    paid = np.concatenate([[0], np.cumsum(np.array(rewards) > 0)])
    start = int(np.argmax(paid[length:] - paid[: len(paid) - length]))
    return start, start + length


def _advance(game: Game, mode: int | None, *, sound: bool = False) -> tuple[NativeCore, Callable[[], object]]:
    """A core after its reset, and a function that plays a frame with random actions of all players."""
    choose = random.Random(0)
    if game.single_player:
        core: NativeCore = NativeCore(game, mode=mode, repeat_action_probability=0.0, sound=sound)
        actions, players = game.minimal_actions, 1
    else:
        assert game.multiplayer is not None
        mode = min(game.multiplayer.modes[game.multiplayer.most_players]) if mode is None else mode
        core = MultiplayerCore(game, mode=mode, sound=sound)
        actions, players = game.multiplayer.minimal_actions, game.multiplayer.players(mode)
    core.reset()
    chosen: list[int] = []

    def play() -> object:
        if core.game_over:
            core.reset()
        if core.frame_number % _HOLD == 0 or not chosen:
            chosen[:] = [int(choose.choice(actions)) for _ in range(players)]
        return core.act(chosen[0]) if game.single_player else core.act_players(chosen)

    return core, play


def _mode_screen(game: Game, mode: int) -> Image:
    core, play = _advance(game, mode)
    screens = []
    for frame in range(_MODE_FRAMES):
        play()
        if frame >= 60 and frame % 10 == 0:
            screens.append(core.screen_rgb().copy())
    core.close()
    return _busiest(screens)


def _write_random(game: Game, path: Path) -> list[Image]:
    """Write a video of random play, and return its screens."""
    core, play = _advance(game, None, sound=True)
    screens: list[Image] = []
    with VideoWriter(path, game, sound=True) as video:
        for _ in range(SECONDS * 60):
            play()
            screens.append(core.screen_rgb().copy())
            video.write(screens[-1], core.audio())
    core.close()
    return screens


def _views(replay: Replay) -> Image:
    """A row for each preset: the stack of one moment of a play, that with the most edges in each preset's image."""
    plays = (replay.observations(Task.of(replay.game.id, preset=name)) for name in PRESETS)
    moments = zip(*(islice(steps, 9, _VIEW_STEPS, 10) for steps in plays), strict=False)
    best = max(moments, key=lambda steps: min(np.count_nonzero(np.diff(step.observation)) for step in steps))
    return np.concatenate([strip(np.asarray(step.observation)) for step in best])
