"""Check sums of what ale-py plays, for `ale_goldens.json`: ale-py is slow, and its answers do not change.

Each function of `SCRIPTS` plays a game by one side, "ale" or "native", and returns the check sums of all results. The
tests compare the native side with the file; `test_ale_goldens.py` plays the other side again in some games.

`PYTHONPATH=tests:tests/support python tests/conformance/ale_goldens.py` writes the file anew, from ale-py alone.
"""

import copy
import itertools
import json
import sys
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import ale_py.env
import numpy as np
from conformance import ale_facts

import atari
from atari import AtariEnv
from atari.cores import AleCore, Core, NativeCore
from atari.cores.verify import VerificationRun

FILE = Path(__file__).with_suffix(".json")
GAMES = [game.id for game in atari.games.playable()]
PADDLE_GAMES = [game.id for game in atari.games.playable() if game.controllers.paddles]
CORE_NUMBERS = ("lives", "game_over", "truncated", "frame_number", "episode_frame_number")


class CheckSum:
    """The CRC-32 of a sequence of results. `trace` notes each number, text and check sum of an array, if it is a list."""

    trace: list[str] | None = None

    def __init__(self) -> None:
        self.crc = 0

    def add(self, result: Any) -> None:
        """Add an array with its type and shape, a collection item by item, or another value by its text."""
        if isinstance(result, np.ndarray):
            self.add(f"{result.dtype}{result.shape}")
            self._add(result.tobytes(), f"an array of check sum {zlib.crc32(result.tobytes()):08x}")
        elif isinstance(result, dict):
            self.add([item for key in result for item in (key, result[key])])
        elif isinstance(result, tuple | list):
            for item in result:
                self.add(item)
        else:
            text = f"{type(result).__name__} {result!r}"
            self._add(text.encode(), text)

    def _add(self, data: bytes, text: str) -> None:
        self.crc = zlib.crc32(data, self.crc)
        if CheckSum.trace is not None:
            CheckSum.trace.append(text)

    def __str__(self) -> str:
        return f"{self.crc:08x}"


# The cores.


def mode_runs(game: str) -> list[VerificationRun]:
    """Each mode with some difficulty and each difficulty with some mode, through a reset and 60 frames."""
    modes, difficulties = atari.games[game].modes, atari.games[game].difficulties
    return [
        VerificationRun(game, 60, seed=i, mode=modes[i % len(modes)], difficulty=difficulties[i % len(difficulties)])
        for i in range(max(len(modes), len(difficulties)))
    ]


def sticky_run(game: str) -> VerificationRun:
    """Sticky actions, which are drawn in every frame."""
    return VerificationRun(game, frames=600, seed=1)


def poke_run(game: str) -> VerificationRun:
    """Overwritten RAM reaches rare states in minutes: illegal opcodes, runaway programs, odd scores."""
    return VerificationRun(game, frames=200, seed=2, pokes=True)


def paddle_run(game: str) -> VerificationRun:
    """Paddles that move by fractions."""
    return VerificationRun(game, frames=400, seed=3, strengths=True, repeat_action_probability=0.5)


def check_sum(run: VerificationRun, side: str) -> str:
    """The check sum of all that `atari.cores.verify` compares, before the first frame and after every frame."""
    core = run.make(side)
    crc, reward, steps = 0, 0, run.steps()
    while True:
        numbers = [int(reward), *(int(getattr(core, name)) for name in CORE_NUMBERS)]
        for part in (str(numbers).encode(), *(getattr(core, name)().tobytes() for name in ("ram", "screen", "audio"))):
            crc = zlib.crc32(part, crc)
        step = next(steps, None)
        if step is None:
            break
        reward = step.play(core)
    core.close()
    return f"{crc:08x}"


def cores_of_middle(game: str, side: str) -> tuple[Core, list[int]]:
    """A core after 100 frames of a game, and the actions of the next 60."""
    core: Core = {"ale": AleCore, "native": NativeCore}[side](game, seed=5, repeat_action_probability=0.25, sound=True)
    actions = [int(action) for action in np.random.default_rng(4).choice(atari.games[game].minimal_actions, 160)]
    core.reset()
    for action in actions[:100]:
        core.act(action)
    return core, actions[100:]


def check_sum_of_middle(core: Core, actions: list[int]) -> str:
    """The check sum of rewards, RAM, all kinds of screen, and sound."""
    found = CheckSum()
    for action in actions:
        found.add(int(core.act(action)))
        found.add([getattr(core, name)() for name in ("ram", "screen", "screen_rgb", "screen_grayscale", "audio")])
    return str(found)


def lives_of_unused_rules(game: str, side: str) -> list[int | bool]:
    """The lives after 150 frames, and whether ale-py truncates there for a lost life.

    ale-py truncates while the lives are fewer than its unused rules count. In Atlantis II ale-py compares with an uninitialised
    variable.
    """
    rules = atari.games[game].rules
    assert rules is not None
    if side == "native":
        core = NativeCore(game, seed=1, repeat_action_probability=0.0)
        for _ in range(150):
            if core.lives >= rules.lives_initial:
                core.act(0)
        lives, truncated = core.lives, core.lives < rules.lives_initial
    else:
        ale = ale_facts.loaded(game, truncate_on_loss_of_life=True)
        for _ in range(150):
            ale.act(0)
        lives, truncated = ale.lives(), ale.game_truncated()
    return [lives] if game == "atlantis2" else [lives, truncated]


# The environments.


class Play:
    """Plays an environment with random actions, each held for some steps, over several episodes."""

    def __init__(self, env: Any) -> None:
        self.env = env
        self.rng = np.random.default_rng(
            list(env.game.id.encode() if isinstance(env, AtariEnv) else env._game.encode())
        )
        self.sum = CheckSum()

    def reset(self, seed: int | None = None) -> None:
        """Reset, and add what is returned."""
        self.add(self.env.reset(seed=seed))

    def steps(self, count: int) -> None:
        """Play steps."""
        action, left = self.sample(), 0
        for _ in range(count):
            if left == 0:
                action, left = self.sample(), int(self.rng.choice((1, 1, 2, 4, 8)))
            left -= 1
            result = self.env.step(action)
            self.add(result)
            if result[2] or result[3]:
                self.reset()

    def sample(self) -> Any:
        """An action of the space."""
        space = self.env.action_space
        if self.env.continuous:
            return np.asarray(self.rng.uniform(space.low, space.high), np.float32)
        return int(self.rng.integers(space.n))

    def add(self, result: Any) -> None:
        """Add a result, and the state of the environment's generator."""
        self.sum.add(result)
        self.sum.add(str(self.env.np_random.bit_generator.state))


def make_env(game: str, side: str, **options: Any) -> Any:
    """ale-py's environment, or ours; both spaces and the meanings of the actions are the same."""
    return (ale_py.env.AtariEnv if side == "ale" else AtariEnv)(game, **options)


def started(env: Any) -> Play:
    """A play that has the spaces and the meanings of the actions in its check sum."""
    play = Play(env)
    play.sum.add([str(env.observation_space), str(env.action_space), env.get_action_meanings()])
    return play


def play_pixels(game: str, side: str) -> str:
    """Colour screens with the default options, 150 steps. On our side a deep copy plays the second half."""
    play = started(make_env(game, side, render_mode="rgb_array"))
    play.sum.add(str(play.env.get_keys_to_action()))
    play.reset(seed=7)
    play.steps(60)
    play.reset()
    play.steps(40)
    if side == "native":
        play.env = copy.deepcopy(play.env)
    play.sum.add(play.env.render())
    play.steps(40)
    play.reset()
    play.steps(10)
    return str(play.sum)


def ram_options(game: str) -> dict[str, Any]:
    """A random frame skip, all actions, the last mode, a limit."""
    facts = atari.games[game]
    assert facts.rules is not None
    return {
        "mode": facts.modes[-1],
        "difficulty": facts.difficulties[-1],
        "obs_type": "ram",
        "frameskip": (2, 5),
        "repeat_action_probability": 0.0,
        "full_action_space": True,
        "max_num_frames_per_episode": max(300, facts.rules.selection_frames),
    }


def play_ram(game: str, side: str) -> str:
    """The RAM of 170 steps."""
    play = started(make_env(game, side, **ram_options(game)))
    play.reset(seed=2**40 + 1)
    play.steps(170)
    return str(play.sum)


def play_grayscale(game: str, side: str) -> str:
    """Grayscale screens with sound and continuous actions, 250 steps."""
    options = {"obs_type": "grayscale", "frameskip": 1, "repeat_action_probability": 0.5}
    more = {"continuous": True, "continuous_action_threshold": 0.3, "sound_obs": True}
    play = started(make_env(game, side, **options, **more))
    play.reset(seed=0)
    play.steps(150)
    play.reset()
    play.steps(100)
    return str(play.sum)


def settings(game: str) -> list[tuple[int, int]]:
    """Each mode with one of the difficulties, and each difficulty with one of the modes."""
    modes, difficulties = atari.games[game].modes, atari.games[game].difficulties
    count = max(len(modes), len(difficulties))
    return list(itertools.islice(zip(itertools.cycle(modes), itertools.cycle(difficulties), strict=False), count))


def play_settings(game: str, side: str) -> list[str]:
    """In each mode and at each difficulty a reset and six steps."""
    seed = 3 if "rng()" in str(atari.games[game].rules) else None  # a reset that draws random words draws the same
    return [_play_setting(env, seed) for env in _envs_of_settings(game, side, seed)]


def _envs_of_settings(game: str, side: str, seed: int | None) -> Iterator[Any]:
    options: dict[str, Any] = {"obs_type": "grayscale", "repeat_action_probability": 0.0, "frameskip": 2}
    if side == "native":
        for mode, difficulty in settings(game):
            yield AtariEnv(game, mode=mode, difficulty=difficulty, **options)
        return
    env = ale_py.env.AtariEnv(game, **options)  # is slow to load a ROM, so the state after loading is restored
    env.seed_game(seed)
    env.load_game()
    loaded = env.ale.cloneSystemState()
    for mode, difficulty in settings(game):
        env.ale.restoreSystemState(loaded)
        env.ale.setMode(mode)
        env.ale.setDifficulty(difficulty)
        yield env


def _play_setting(env: Any, seed: int | None) -> str:
    found = CheckSum()
    observation, info = env.reset(seed=seed if isinstance(env, AtariEnv) else None)
    info.pop("seeds", None)
    found.add((observation, info))
    for action in (1, 2, 0, 3, 1, 0):
        found.add(env.step(action % len(env.get_action_meanings())))
    return str(found)


SCRIPTS: dict[str, Callable[[str, str], Any]] = {
    "facts": ale_facts.facts,
    "rules": ale_facts.rules,
    "modes": lambda game, side: [check_sum(run, side) for run in mode_runs(game)],
    "sticky": lambda game, side: check_sum(sticky_run(game), side),
    "pokes": lambda game, side: check_sum(poke_run(game), side),
    "paddles": lambda game, side: check_sum(paddle_run(game), side) if game in PADDLE_GAMES else "",
    "middle": lambda game, side: check_sum_of_middle(*cores_of_middle(game, side)),
    "unused rules": lives_of_unused_rules,
    "pixels": play_pixels,
    "ram": play_ram,
    "grayscale": play_grayscale,
    "settings": play_settings,
}
"""By name, what is played by one side ("ale" or "native") in a game."""


def difference(game: str, name: str) -> str:
    """The first result of a script in which our side differs from ale-py, with the result before it."""
    traces: list[list[str]] = []
    answers = []
    for side in ("native", "ale"):
        traces.append([])
        CheckSum.trace = traces[-1]
        answers.append(SCRIPTS[name](game, side))
    CheckSum.trace = None
    for number, (ours, theirs) in enumerate(zip(*traces, strict=False)):
        if ours != theirs:
            return f"{name}, result {number} after {traces[0][number - 1]!r}: {ours} differs from ale-py's {theirs}"
    return f"{name}: {answers[0]}, and ale-py's {answers[1]}; `atari verify` names differences of cores"


if __name__ == "__main__":
    lines = []
    for game in GAMES:
        lines.append(f'"{game}": {json.dumps({name: play(game, "ale") for name, play in SCRIPTS.items()})}')
        print(game, file=sys.stderr)
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
