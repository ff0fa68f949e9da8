"""Programs for ale-py's raw interface, as its users write them. Each takes the module and returns what it saw."""

import copy
import hashlib
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

Program = Callable[[Any], Iterator[Any]]


def made(ale_py: Any, game: str, seed: int = 123, **settings: Any) -> Any:
    """An interface with a game, set up before the load."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", seed)
    setters = {bool: ale.setBool, int: ale.setInt, float: ale.setFloat, str: ale.setString}
    for name, value in settings.items():
        setters[type(value)](name, value)
    ale.loadROM(ale_py.roms.get_rom_path(game))
    ale.reset_game()
    return ale


def random_agent(ale_py: Any) -> Iterator[Any]:
    """The program of ale-py's own examples: legal actions at random, and the score of each game."""
    ale = made(ale_py, "breakout", repeat_action_probability=0.25)
    actions = ale.getLegalActionSet()
    rng = np.random.default_rng(1)
    for _ in range(2):
        score = 0
        while not ale.game_over():
            score += ale.act(actions[rng.integers(len(actions))])
            yield ale.lives(), ale.getEpisodeFrameNumber(), ale.getFrameNumber()
        yield score
        ale.reset_game()


def deep_q_preprocessing(ale_py: Any) -> Iterator[Any]:
    """Frame skip by the emulator, the maximum of two gray screens in buffers of one's own, lives."""
    ale = made(ale_py, "space_invaders", 7, frame_skip=4, repeat_action_probability=0.0)
    height, width = ale.getScreenDims()
    screens = np.zeros((2, height, width), np.uint8)
    actions = ale.getMinimalActionSet()
    rng = np.random.default_rng(2)
    for step in range(300):
        reward = ale.act(actions[rng.integers(len(actions))])
        ale.getScreenGrayscale(screens[step % 2])
        yield reward, ale.lives(), ale.game_over(), screens.max(axis=0)


def search_tree(ale_py: Any) -> Iterator[Any]:
    """Iterated width: each action from a cloned state, RAM as the features, then the best one."""
    ale = made(ale_py, "seaquest", 3, repeat_action_probability=0.0)
    actions = ale.getMinimalActionSet()
    seen: set[tuple[int, int]] = set()
    for _ in range(5):
        root = ale.cloneState()
        returns = []
        for action in actions:
            reward = sum(ale.act(action) for _ in range(8))
            features = {*enumerate(ale.getRAM().tolist())}
            returns.append((reward, len(features - seen)))
            seen |= features
            ale.restoreState(root)
        best = max(range(len(actions)), key=returns.__getitem__)
        yield returns, best
        for _ in range(8):
            ale.act(actions[best])
        yield ale.getScreenRGB()


def sticky_search(ale_py: Any) -> Iterator[Any]:
    """The system state continues with the same random numbers, the state with others."""
    ale = made(ale_py, "pong", 5, repeat_action_probability=0.5)
    for action in (2, 3) * 20:
        ale.act(action)
    system, state = ale.cloneSystemState(), ale.cloneState()
    for saved, restore in (
        (system, ale.restoreSystemState),
        (state, ale.restoreState),
        (system, ale.restoreSystemState),
    ):
        restore(saved)
        for action in (2, 3, 0) * 15:
            ale.act(action)
        yield ale.getRAM()


def modes(ale_py: Any) -> Iterator[Any]:
    """Every mode and difficulty of a game."""
    ale = made(ale_py, "kaboom")
    yield ale.getAvailableModes(), ale.getAvailableDifficulties()
    ale.loadROM(ale_py.roms.get_rom_path("breakout"))
    for mode in ale.getAvailableModes():
        ale.setMode(mode)
        for difficulty in ale.getAvailableDifficulties():
            ale.setDifficulty(difficulty)
            ale.reset_game()
            for _ in range(30):
                ale.act(1)
            state = ale.cloneState()
            yield state.getCurrentMode(), state.getDifficulty(), ale.getScreen()


def limits(ale_py: Any) -> Iterator[Any]:
    """Truncated episodes, and a setting that applies at the next load."""
    ale = made(ale_py, "freeway", max_num_frames_per_episode=50)
    while not ale.game_over():
        ale.act(2)
    yield ale.game_over(), ale.game_over(with_truncation=False), ale.game_truncated(), ale.getEpisodeFrameNumber()
    ale.setInt("max_num_frames_per_episode", 80)
    ale.reset_game()
    while not ale.game_over():
        ale.act(2)
    yield ale.getEpisodeFrameNumber(), ale.getFrameNumber()
    ale.loadROM(ale_py.roms.get_rom_path("freeway"))
    ale.reset_game()
    while not ale.game_over():
        ale.act(2)
    yield ale.getEpisodeFrameNumber(), ale.getFrameNumber()


def sound(ale_py: Any) -> Iterator[Any]:
    """The samples of each frame."""
    ale = made(ale_py, "asteroids", 9, sound_obs=True)
    samples = np.zeros(ale.getAudioSize(), np.uint8)
    for step in range(60):
        ale.act(step % 18)
        ale.getAudio(samples)
        yield samples.copy(), ale.getAudio()


def pokes(ale_py: Any) -> Iterator[Any]:
    """Writes to RAM before each action."""
    ale = made(ale_py, "ms_pacman", 4)
    for step in range(60):
        ale.setRAM(step, 255 - step)
        yield ale.act(2), ale.getRAM(), ale.getScreenRGB()


def carried_states(ale_py: Any) -> Iterator[Any]:
    """A state in another interface, pickled, copied and as bytes."""
    first = made(ale_py, "enduro", 1, repeat_action_probability=0.0)
    second = made(ale_py, "enduro", 2, repeat_action_probability=0.0)
    for _ in range(40):
        first.act(1)
    state = first.cloneState()
    for carried in (
        pickle.loads(pickle.dumps(state)),
        copy.deepcopy(state),
        ale_py.ALEState(state.serialize()),
    ):
        yield isinstance(carried, ale_py.ALEState), carried == state, carried.getFrameNumber()
        second.restoreState(carried)
        for _ in range(20):
            second.act(3)
        yield second.getRAM(), second.getScreenRGB()


def several_games(ale_py: Any) -> Iterator[Any]:
    """One interface that loads one game after the other; the settings stay."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 11)
    ale.setBool("color_averaging", True)
    ale.setLoggerMode(ale_py.LoggerMode.Error)
    yield sorted(ale_py.roms.get_all_rom_ids())
    for game in ("qbert", "tennis", "montezuma_revenge", "qbert"):
        path = ale_py.roms.get_rom_path(game)
        yield ale_py.ALEInterface.isSupportedROM(path), ale.isSupportedROM(str(path))
        ale.loadROM(str(path))
        yield ale.getFrameNumber(), ale.getRAM()
        ale.reset_game()
        for action in ale.getMinimalActionSet():
            ale.act(action.value)
        yield [(action.name, action.value) for action in ale.getMinimalActionSet()], ale.getScreenRGB()
    yield ale.getInt("random_seed"), ale.getBool("color_averaging"), ale.getFloat("repeat_action_probability")


def paddles(ale_py: Any) -> Iterator[Any]:
    """Actions with a strength, by value and as an enum."""
    ale = made(ale_py, "breakout", 6)
    for step in range(80):
        yield ale.act(ale_py.Action.RIGHT if step % 3 else 4, paddle_strength=0.25 + step / 160), ale.getRAM()


def without_a_reset(ale_py: Any) -> Iterator[Any]:
    """Frames right after the load."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 8)
    ale.loadROM(ale_py.roms.get_rom_path("pitfall"))
    for _ in range(90):
        yield ale.act(3), ale.lives(), ale.getRAM()


def environments(ale_py: Any) -> Iterator[Any]:
    """The two environments of the module."""
    env = ale_py.AtariEnv("alien", obs_type="ram")
    yield from env.reset(seed=1)
    for action in range(10):
        yield from env.step(action)
    envs = ale_py.AtariVectorEnv("alien", num_envs=2)
    yield envs.reset(seed=1)[0]
    for action in range(10):
        yield from envs.step(np.array([action, 0]))[:4]
    envs.close()
    yield ale_py.env.AtariEnv is ale_py.AtariEnv, ale_py.vector_env.AtariVectorEnv is ale_py.AtariVectorEnv


PROGRAMS: tuple[Program, ...] = (
    random_agent,
    deep_q_preprocessing,
    search_tree,
    sticky_search,
    modes,
    limits,
    sound,
    pokes,
    carried_states,
    several_games,
    paddles,
    without_a_reset,
    environments,
)


def digest(program: Program, ale_py: Any) -> str:
    """A hash of all that a program saw."""
    seen = hashlib.sha256()
    for each in program(ale_py):
        for part in each if isinstance(each, tuple) else (each,):
            seen.update(part.tobytes() if isinstance(part, np.ndarray) else repr(part).encode())
    return seen.hexdigest()
