"""Gymnasium's wrappers, and `gymnasium.utils.play`, do with these environments what they do with ale-py's."""

from collections.abc import Iterator
from typing import Any

import ale_py.env
import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1, needs_new_ale_py
from gymnasium import wrappers
from gymnasium.utils.env_checker import data_equivalence

import atari
from atari import AtariEnv

pytestmark = [needs_gymnasium_1, needs_new_ale_py]
pygame = pytest.importorskip("pygame")


@pytest.fixture(scope="module")
def ids() -> Iterator[tuple[str, str]]:
    """The same game under an ID of each package."""
    entries = {
        "AtariEnvs-v0": ("atari.env:AtariEnv", "atari.vector:AtariVectorEnv"),
        "AlePy-v0": ("ale_py.env:AtariEnv", "ale_py.vector_env:AtariVectorEnv"),
    }
    for env_id, (entry, vector_entry) in entries.items():
        gymnasium.register(env_id, entry, kwargs={"game": "breakout"}, vector_entry_point=vector_entry)
    yield "AtariEnvs-v0", "AlePy-v0"
    for env_id in entries:
        del gymnasium.registry[env_id]


@pytest.fixture(scope="module")
def vectors(ids: tuple[str, str]) -> "list[gymnasium.vector.VectorEnv[Any, Any, Any]]":
    """A vector of each package. Both play the same in all tests: ale-py would load the game again for a seed of each."""
    made = [gymnasium.make_vec(env_id, 2, vectorization_mode="vector_entry_point") for env_id in ids]
    for envs in made:
        envs.reset(seed=1)
    return made


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("TimeLimit", {"max_episode_steps": 20}),
        ("FrameStackObservation", {"stack_size": 3}),
        ("DelayObservation", {"delay": 2}),
        ("MaxAndSkipObservation", {}),
        ("StickyAction", {"repeat_action_probability": 0.5}),
        ("RepeatAction", {"num_repeats": 2}),
        ("GrayscaleObservation", {}),
        ("ResizeObservation", {"shape": (84, 84)}),
        ("NormalizeReward", {}),
    ],
)
def test_wrappers(ids: tuple[str, str], name: str, options: dict[str, Any]) -> None:
    envs = [getattr(wrappers, name)(gymnasium.make(env_id), **options) for env_id in ids]
    for seed in (1, None):  # a reset after `close` goes on
        first, second = (env.reset(seed=seed) for env in envs)
        assert data_equivalence(first, second)
        for action in (1, 2, 3) * 10:
            first, second = (env.step(action) for env in envs)
            assert data_equivalence(first, second)
            if first[2] or first[3]:
                break
        for env in envs:
            env.close()


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("FlattenObservation", {}),
        ("DtypeObservation", {"dtype": np.int32}),
        ("ReshapeObservation", {"shape": (4, 7056)}),
        ("ClipReward", {"min_reward": -0.25, "max_reward": 0.75}),
        ("RecordEpisodeStatistics", {}),
        ("NormalizeReward", {}),
        ("NormalizeObservation", {}),
        ("DictInfoToList", {}),
    ],
)
def test_wrappers_of_vectors(vectors: list[Any], name: str, options: dict[str, Any]) -> None:
    envs = [getattr(wrappers.vector, name)(env, **options) for env in vectors]
    first, second = (env.reset()[0] for env in envs)
    assert data_equivalence(first, second)
    for action in range(30):
        first, second = (env.step(np.full(2, action % 4))[:4] for env in envs)
        assert data_equivalence(first, second)


@pytest.mark.parametrize("wrapped", [False, True])
def test_play(ids: tuple[str, str], monkeypatch: pytest.MonkeyPatch, wrapped: bool) -> None:
    """The keys that are pressed give the actions, and the same observations as steps with them."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    from gymnasium.utils.play import play

    played = []
    for env_id, kind in zip(ids, (AtariEnv, ale_py.env.AtariEnv), strict=True):
        steps: list[Any] = []

        def press(_before: Any, after: Any, action: Any, *_rest: Any, steps: list[Any] = steps) -> None:
            steps.append((action, after))
            down = len(steps) % 2 == 1
            key = {"key": ord("d") if len(steps) % 4 < 2 else ord(" ")}
            kinds = pygame.event.Event(pygame.KEYDOWN if down else pygame.KEYUP, key)
            pygame.event.post(kinds if len(steps) < 12 else pygame.event.Event(pygame.QUIT))

        env = gymnasium.make(env_id, render_mode="rgb_array") if wrapped else kind("breakout", render_mode="rgb_array")
        play(env, callback=press, seed=1, fps=None if kind is AtariEnv else 1000)
        played.append(steps)
    assert len(played[0]) == 12
    assert {action for action, _ in played[0]} > {0}
    assert data_equivalence(*played)


def test_a_threshold_without_continuous_actions_is_accepted_as_by_ale_py() -> None:
    """Dopamine gives one to every environment; `atari.make` refuses it."""
    env = gymnasium.make("ALE/Pong-v5", continuous=False, continuous_action_threshold=0.0)
    assert env.unwrapped.task == atari.Task.of("ALE/Pong-v5")
    with pytest.raises(ValueError, match=r"continuous_action_threshold=0\.0 has no effect"):
        atari.make("pong", continuous_action_threshold=0.0)
