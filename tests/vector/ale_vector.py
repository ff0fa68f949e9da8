"""Games in ale-py's vector environment and in ours of the same name, with the same options, seeds and actions.

`ale_vector.json` has a check sum of what ale-py returns in each case, because ale-py is slow, and its answers do not change.
`PYTHONPATH=tests python tests/vector/ale_vector.py` writes the file anew, from ale-py alone.
"""

import zlib
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import ale_py
import numpy as np

import atari
from atari.base.gymnasium_versions import AutoresetMode

ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)

FILE = Path(__file__).with_suffix(".json")
GAMES = [game.id for game in atari.games.playable()]
NUMBERS = ("env_id", "lives", "frame_number", "episode_frame_number")
NEXT, SAME = AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP


class Case(NamedTuple):
    """Some steps of random actions, in which at least `ends` episodes end."""

    game: str
    steps: int
    seed: int
    options: dict[str, Any]
    num_envs: int = 1
    ends: int = 0


def played(case: Case, side: str) -> Iterator[tuple[str, Any]]:
    """Everything that a vector environment of a side ("ale" or "native") has and returns, each with its name."""
    kind = {"ale": ale_py, "native": atari}[side].AtariVectorEnv  # type: ignore[attr-defined]
    envs = kind(case.game, case.num_envs, num_threads=1, **case.options)
    for name in ("single_action_space", "single_observation_space", "action_space", "observation_space"):
        yield name, np.frombuffer(str(getattr(envs, name)).encode(), np.uint8)
    observation, info = envs.reset(seed=case.seed)
    generator = np.random.default_rng(case.seed)
    for step in range(case.steps + 1):
        yield f"observation {step}", observation
        for name in NUMBERS:
            yield f"{name} {step}", info[name]
        if step == case.steps:
            break
        begun = info["episode_frame_number"]
        observation, *signals, info = envs.step(choose(generator, envs, case.num_envs))
        for name, array in zip(("reward", "terminated", "truncated"), signals, strict=True):
            yield f"{name} of step {step}", array
        ended = signals[1] | signals[2]
        yield f"ended in step {step}", ended
        if "final_obs" in info:
            if "life_loss_info" in case.options:  # after a reported life the game goes on
                ended &= info["episode_frame_number"] < begun
            yield f"final_obs of step {step}", info["final_obs"][ended]
            if side == "native":
                assert np.array_equal(info["_final_obs"], ended)
                assert not info["final_obs"][~ended].any()
    envs.close()


def sums(case: Case, side: str) -> list[int]:
    """The check sum of everything, by name, type and shape; and the number of episodes that end."""
    crc = ends = 0
    for name, array in played(case, side):
        crc = zlib.crc32(f"{name} {array.dtype} {array.shape}".encode(), crc)
        crc = zlib.crc32(np.ascontiguousarray(array).tobytes(), crc)
        ends += int(array.sum()) if name.startswith("ended") else 0
    return [crc, ends]


def difference(case: Case) -> str | None:
    """The first array that differs in name, type, shape or a value."""
    for (name, mine), (other_name, other) in zip(played(case, "native"), played(case, "ale"), strict=True):
        ours, theirs = (name, mine.dtype, mine.shape), (other_name, other.dtype, other.shape)
        if ours != theirs or not np.array_equal(mine, other):
            return f"{case}: {ours} differs from ale-py's {theirs}"
    return None


def choose(generator: np.random.Generator, envs: Any, num_envs: int) -> Any:
    """Random actions: indices, or radius, angle and fire."""
    if hasattr(envs.single_action_space, "n"):
        return generator.integers(0, envs.single_action_space.n, num_envs)
    low, high = envs.single_action_space.low, envs.single_action_space.high
    return generator.uniform(low, high, (num_envs, 3)).astype(np.float32)


def with_random_options(count: int, seed: int) -> Iterator[Case]:
    """Games with random options."""
    generator = np.random.default_rng(seed)
    games = [game for game in GAMES if game not in ("skiing", "lost_luggage")]

    def one_of(*values: Any) -> Any:
        return values[generator.integers(len(values))]

    sizes = ((84, 84), (84, 84), (84, 84), (96, 72), (105, 80), (64, 64), (210, 160), (70, 32), (100, 11))
    for _ in range(count):
        height, width = one_of(*sizes)
        game = games[generator.integers(len(games))]
        options = {
            "img_height": height,
            "img_width": width,
            "grayscale": one_of(True, True, False),
            "stack_num": one_of(1, 2, 4, 4, 5),
            "frameskip": one_of(1, 2, 3, 4, 4, 7),
            "maxpool": one_of(True, True, False),
            "noop_max": one_of(0, 1, 7, 30, 30),
            "episodic_life": one_of(True, False),
            "life_loss_info": one_of(True, False),
            "reward_clipping": one_of(True, False),
            "use_fire_reset": one_of(True, True, False),
            "max_num_frames_per_episode": one_of(37, 101, 402, 108000),
            "repeat_action_probability": one_of(0.0, 0.25, 0.5),
            "full_action_space": one_of(True, False),
            "continuous": one_of(True, False, False),
            "continuous_action_threshold": one_of(0.3, 0.5),
            "autoreset_mode": one_of(NEXT, SAME),
        }
        yield Case(game, 60, 7, _with_effect(options))


def _with_effect(options: dict[str, Any]) -> dict[str, Any]:
    """The options that have an effect together: ale-py ignores the others, and ours raises errors for them."""
    without = {
        "continuous_action_threshold": not options["continuous"],
        "life_loss_info": options["episodic_life"],
    }
    return {name: value for name, value in options.items() if not without.get(name, False)}


def _cases() -> Iterator[tuple[str, Case]]:
    for number, game in enumerate(GAMES):
        mode = (NEXT, SAME)[number % 2]
        yield game, Case(game, 20, number, {"autoreset_mode": mode, "max_num_frames_per_episode": 41})
    for number, case in enumerate(with_random_options(20, seed=1)):
        yield f"random options {number}", case
    for mode in (NEXT, SAME):
        episodes = {"autoreset_mode": mode, "frameskip": 5}
        yield f"whole episodes, {mode.value}", Case("breakout", 400, 3, episodes, 2, ends=3)
    yield "lives that end episodes", Case("breakout", 300, 11, {"episodic_life": True}, 2, ends=9)
    reported = {"life_loss_info": True, "autoreset_mode": SAME}
    yield "lives that are reported", Case("ms_pacman", 300, 2, reported, 2, ends=1)
    # Frames of the screen's own size are not scaled. An episode ends inside a skip, and the next one follows.
    screen = {"grayscale": False, "img_height": 210, "img_width": 160, "max_num_frames_per_episode": 42}
    for (frameskip, maxpool, stack), mode in product(
        [(4, True, 1), (5, True, 2), (1, True, 1), (3, False, 4)], (NEXT, SAME)
    ):
        options = {"frameskip": frameskip, "maxpool": maxpool, "stack_num": stack, "autoreset_mode": mode}
        for seed, game in enumerate(("breakout", "seaquest")):
            name = f"the size of the screen, {game}, {frameskip} frames, {mode.value}"
            yield name, Case(game, 30, seed, {**screen, **options})
    yield "more no-ops than an episode has frames", Case("alien", 10, 6, {"noop_max": 1000})


CASES = dict(_cases())

if __name__ == "__main__":
    lines = [f'"{name}": {sums(case, "ale")}' for name, case in CASES.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
