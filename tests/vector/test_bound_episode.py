"""`_emulator.Episode`: callbacks, errors, cores of every kind, threads, forks and states."""

import functools
import gc
import os
import random
import threading
import weakref
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from tasks import nested

import atari
import atari._emulator as _emulator
from atari.cores import AleCore, NativeCore
from atari.env.settings import make_episode
from atari.task import Task
from atari.vector.seeds import seed_words

BASELINES = Task.of("breakout", preset="baselines")


def episode_of(task: Task, draw: Callable[[int, int], int] | None = None) -> _emulator.Episode:
    return make_episode(task, stacked=task.stack_num is not None, draw=draw)


def core_of(task: Task, kind: Any = NativeCore) -> Any:
    return kind(task.definition, seed=1, repeat_action_probability=task.repeat_action_probability)


class Game:
    """A core with an episode that has drawn the same numbers in every test."""

    def __init__(self, task: Task = BASELINES, kind: Any = NativeCore, wrap: Callable[[Any], Any] = lambda core: core):
        numbers = random.Random(3)
        self.core = wrap(core_of(task, kind))
        self.episode = episode_of(task, lambda low, high: numbers.randrange(low, high))

    def begin(self) -> Any:
        self.core.reset()
        return self.core

    def reset(self, **options: Any) -> tuple[Any, dict[str, Any]]:
        return self.episode.reset(self.core, self.begin, **options)

    def step(self, action: int, on_frame: Any = None) -> Any:
        return self.episode.step(self.core, action, 1.0, on_frame)


class ByMethods:
    """A core of a user's, which Python plays."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __getattr__(self, name: str) -> Any:
        return getattr(self._core, name)


class Overriding(NativeCore):
    """A native core with an `act` of its own, which an episode must call."""

    actions: list[int] = []  # noqa: RUF012

    def act(self, action: int, strength: float = 1.0) -> int:
        self.actions.append(action)
        return super().act(action, strength)


class Wrapping(Overriding):
    """A native core whose `act` names the method that it replaces."""

    act = functools.wraps(NativeCore.act)(lambda self, action, strength=1.0: Overriding.act(self, action, strength))


def played(game: Game, steps: int, each: Any = None) -> list[Any]:
    """The results of steps, with a reset after each end."""
    shown = [_bytes(game.reset(on_frame=each))]
    actions = random.Random(5)
    for _ in range(steps):
        result = game.step(actions.choice((0, 1, 3, 4)), each)
        shown.append(_bytes(result))
        if result[2] or result[3]:
            shown.append(_bytes(game.reset(on_frame=each)))
    return shown


def _bytes(result: tuple[Any, ...]) -> Any:
    info = {key: value if key != "episode" else [value[part] for part in "rl"] for key, value in result[-1].items()}
    return result[0].tobytes(), result[1:-1], info


@pytest.mark.parametrize(
    ("kind", "wrap"),
    [
        (NativeCore, ByMethods),
        (Overriding, lambda core: core),
        (Wrapping, lambda core: core),
        (atari.cores.PlainCore, lambda core: core),
        (AleCore, lambda core: core),
    ],
)
def test_every_core_gives_the_same_bytes(kind: Any, wrap: Any) -> None:
    Overriding.actions.clear()
    assert played(Game(kind=kind, wrap=wrap), 120) == played(Game(), 120)
    assert bool(Overriding.actions) == (kind in (Overriding, Wrapping))


def test_an_episode_with_its_own_generator_is_a_lane_of_a_vector() -> None:
    task = Task.of("breakout", preset="envpool", frameskip=(2, 5), noops=(1, 30))
    envs = atari.AtariVectorEnv(task, 1, num_threads=1)
    episode, core = episode_of(task), core_of(task)
    words = seed_words(7, [True], ale=False)[1][0]

    def begin() -> Any:
        core.seed(words[0])
        core.reset()
        return core

    observation, info = envs.reset(seed=7)
    own, own_info = episode.reset(core, begin, seed=words)
    actions = random.Random(1)
    for _ in range(200):
        assert own.tobytes() == observation[0].tobytes()
        assert own_info["frame_number"] == info["frame_number"][0]
        action = actions.randrange(4)
        observation, _, terminated, truncated, info = envs.step(np.array([action]))
        own, _, *ends, own_info = episode.step(core, int(task.action_set[action]))
        assert ends == [terminated[0], truncated[0]]
        if any(ends):
            observation, *_, info = envs.step(np.array([0]))
            own, own_info = episode.reset(core, begin)


def test_a_callback_is_called_after_each_frame_with_the_present_core() -> None:
    def entry(core: Any, action: int, reward: int) -> tuple[Any, ...]:
        return action, reward, core.frame_number, core.ram().tobytes(), core.screen_rgb().tobytes()

    class Observer:
        def game_begun(self) -> None:
            seen[0].append("begun")

        def frame_played(self, action: int, reward: int) -> None:
            seen[0].append(entry(env.unwrapped.core, action, reward))

    seen: tuple[list[Any], list[Any]] = [], []
    env = nested(BASELINES)
    env.unwrapped.driver.observers.append(Observer())
    env.reset(seed=5)
    other = nested(BASELINES).unwrapped
    episode = episode_of(BASELINES, other.driver.draw)

    def begin() -> Any:
        other.reset(seed=5)
        seen[1].append("begun")
        return other.core

    def on_frame(action: int, reward: int) -> None:
        seen[1].append(entry(other.core, action, reward))

    episode.reset(other.core, begin, on_frame=on_frame)
    for action in (0, 1, 2, 3) * 20:
        env.step(action)
        episode.step(other.core, int(BASELINES.action_set[action]), 1.0, on_frame)
    assert seen[0] == seen[1]
    assert len(seen[0]) > 300


@pytest.mark.parametrize("wrap", [lambda core: core, ByMethods])
def test_a_step_is_played_to_its_end_after_an_error_of_a_callback(wrap: Any) -> None:
    game, other = Game(wrap=wrap), Game()
    game.reset()
    other.reset()
    calls = []

    def fail(action: int, reward: int) -> None:
        calls.append(game.core.ram().sum())
        if len(calls) == 2:
            raise KeyError("mine")

    before = game.core.frame_number
    with pytest.raises(KeyError, match="mine"):
        game.step(1, fail)
    assert (len(calls), game.core.frame_number - before) == (2, 4)
    other.step(1)
    assert (game.episode.steps, game.episode.score) == (other.episode.steps, other.episode.score) == (1, 0)
    assert _bytes(game.step(3)) == _bytes(other.step(3))


def test_a_reset_ends_after_an_error_of_a_callback() -> None:
    game, frames = Game(), []

    def fail(action: int, reward: int) -> None:
        frames.append(action)
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        game.reset(noops=1000, on_frame=fail)
    assert frames == [0]
    assert game.core.episode_frame_number == 1
    assert game.reset(noops=7)[1]["episode_frame_number"] == 15  # whole skips of FIRE and the third action follow


def test_calls_of_one_episode_do_not_overlap() -> None:
    game = Game()
    game.reset()
    errors = []

    def again(action: int, reward: int) -> None:
        for call in (lambda: game.step(0), game.reset, game.episode.save):
            try:
                call()
            except RuntimeError as error:
                errors.append(str(error))

    game.step(1, again)
    assert len(errors) == 12
    assert all("this episode is being played" in error for error in errors)
    game.step(1)


def test_a_callback_that_closes_the_core_ends_the_step() -> None:
    game = Game()
    game.reset()
    with pytest.raises(RuntimeError, match="this core is closed"):
        game.step(1, lambda action, reward: game.core.close())
    game.core = core_of(BASELINES)
    game.reset()
    game.step(1)


def test_an_error_of_begin_changes_nothing() -> None:
    task = BASELINES.replace(noops=(0, 0), fire="never", third_action=False)
    game, other = Game(task), Game(task)
    for one in (game, other):
        one.reset()
        while not one.step(1)[2]:
            pass

    def fail() -> Any:
        raise KeyError("no game")

    with pytest.raises(KeyError, match="no game"):
        game.episode.reset(game.core, fail, new_game=True)
    assert _bytes(game.reset()) == _bytes(other.reset())  # both continue the game
    assert game.core.episode_frame_number > 4


def test_a_reset_goes_on_with_the_core_that_begin_returns() -> None:
    native, python = Game(), Game(wrap=ByMethods)
    expected = [_bytes(game.reset(noops=3)) for game in (Game(), Game())]
    for first, second in ((native, python), (python, native)):
        first.episode.reset(first.core, second.begin, noops=3)
        assert _bytes(first.episode.step(second.core, 1)) == _bytes(_after(second.core, 3))
    assert expected[0] == expected[1]


def _after(core: Any, noops: int) -> Any:
    """The results of a step of FIRE in an episode that begins like the core's."""
    game = Game()
    game.reset(noops=noops)
    return game.step(1)


def drawing(number: Any) -> None:
    """Begin an episode that draws this number of no-ops; after an error it can begin."""
    core = core_of(BASELINES)
    episode = episode_of(BASELINES, lambda low, high: number)

    def begin() -> Any:
        core.reset()
        return core

    try:
        episode.reset(core, begin)
    finally:
        episode.reset(core, begin, noops=2)


def with_core_of(name: str, value: Any) -> None:
    """Begin an episode of a core with another method or attribute of this name."""
    wrong = type("Wrong", (ByMethods,), {name: staticmethod(value) if callable(value) else value})
    Game(wrap=wrong).reset(noops=3)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (partial(drawing, -1), ValueError, r"draw must return a number within 1..30, got -1"),
        (partial(drawing, 31), ValueError, r"draw must return a number within 1..30, got 31"),
        (partial(drawing, 2**40), TypeError, "that draw returns must be an integer of 32 bits, got 1099511627776"),
        (partial(drawing, "3"), TypeError, "the number that draw returns must be an integer of 32 bits, got '3'"),
        (partial(drawing, None), TypeError, "must be an integer"),
        *(
            (
                partial(with_core_of, "screen", lambda frame=frame: frame),
                TypeError,
                "is a core, or a C-contiguous uint8",
            )
            for frame in (np.zeros((200, 160), np.uint8), np.zeros((210, 160), np.int8), None)
        ),
        (partial(with_core_of, "lives", "three"), TypeError, "lives must be an integer of 32 bits, got 'three'"),
        (
            partial(with_core_of, "frame_number", None),
            TypeError,
            "frame_number must be an integer of 32 bits, got None",
        ),
        (partial(with_core_of, "act", lambda *_: 0.5), TypeError, "the reward of the core's act must be .*, got 0.5"),
        (lambda: Game().episode.step(object(), 0), AttributeError, "frame_number"),
    ],
)
def test_wrong_values_are_refused(call: Callable[[], None], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_a_core_of_another_size_is_refused() -> None:
    game, other = Game(), Game(Task.of("pacman", preset="baselines"))
    game.reset()
    with pytest.raises(ValueError, match="another size or TV format"):
        game.episode.step(other.core, 0)
    game.step(0)


@pytest.mark.parametrize("action", [18, -1, "up", None, [1, 2]])
def test_actions_out_of_range_are_refused(action: Any) -> None:
    game = Game()
    game.reset()
    before = game.core.frame_number
    with pytest.raises((TypeError, ValueError), match="action"):
        game.step(action)
    assert game.core.frame_number == before


def test_a_saved_state_continues_exactly() -> None:
    game = Game()
    game.reset()
    for _ in range(30):
        game.step(1)
    state, core = game.episode.save(), game.core.clone_state(include_rng=True)
    first = [_bytes(game.step(action)) for action in (1, 3, 4, 0) * 5]
    game.core.restore_state(core)
    game.episode.load(state)
    assert [_bytes(game.step(action)) for action in (1, 3, 4, 0) * 5] == first
    with pytest.raises(ValueError, match="bytes, got"):
        game.episode.load(state[:-1])


@pytest.mark.parametrize("preset", ["baselines", "gymnasium", "ale_vector"])
def test_damaged_states_crash_nothing(preset: str) -> None:
    task = Task.of("breakout", preset=preset)
    noise = random.Random(1)
    for own in (True, False):
        game = Game(task)
        game.episode = episode_of(task, None if own else lambda low, high: low)
        size = len(game.episode.save())
        for _ in range(20):
            game.episode.load(noise.randbytes(size))
            game.core.reset()
            for action in (0, 1):
                game.step(action)
            game.reset()


def test_threads_share_an_episode_and_its_core() -> None:
    game = Game()
    game.reset()
    refused, stop = [0], threading.Event()

    def read() -> None:
        while not stop.is_set():
            game.core.ram()
            try:
                game.step(1)
            except RuntimeError:
                refused[0] += 1

    threads = [threading.Thread(target=read) for _ in range(3)]
    for thread in threads:
        thread.start()
    frames = 0
    for _ in range(200):
        try:
            game.step(1, lambda action, reward: game.core.screen_rgb())
            frames += 4
        except RuntimeError:
            refused[0] += 1
    stop.set()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    game.step(1)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_process_may_be_forked_in_a_callback() -> None:
    game, other = Game(), Game()
    game.reset()
    other.reset()
    codes = []

    def fork(action: int, reward: int) -> None:
        if codes:
            return
        child = os.fork()
        if child == 0:
            try:
                code = int(game.core.ram().shape != (128,))
            finally:
                os._exit(code)
        codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))

    result = game.step(1, fork)
    assert codes == [0]
    assert _bytes(result) == _bytes(other.step(1))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_child_process_plays_the_step_to_its_end() -> None:
    game = Game()
    game.reset()
    children: list[int] = []
    result = game.step(1, lambda action, reward: children.append(os.fork()) if not children else None)
    if children[0] == 0:
        os._exit(0 if game.step(1)[4]["frame_number"] == result[4]["frame_number"] + 4 else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(children[0], 0)[1]) == 0


def test_an_episode_is_collected_with_the_object_whose_numbers_it_draws() -> None:
    class Owner:
        def __init__(self) -> None:
            self.episode = episode_of(BASELINES, self.draw)

        def draw(self, low: int, high: int) -> int:
            return low

    owner = Owner()
    gone = weakref.ref(owner)
    del owner
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"idle": []}, "an idle action of each player"),
        ({"rows": 0}, "rows must be within"),
        ({"format": "VGA"}, "format"),
    ],
)
def test_wrong_arguments_are_refused(changed: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"rows": 210, "format": "NTSC", "begin_actions": [0, 1], "idle": [0], **changed}
    with pytest.raises(ValueError, match=message):
        _emulator.Episode(_emulator.EpisodeSettings(), _emulator.ObservationSettings(), **arguments)
