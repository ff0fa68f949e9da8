"""Seeds of ale-py's vector environment: starts, frame skips and sticky actions of a seed, and what keeps them."""

import copy
from typing import Any

import ale_py
import numpy as np
import pytest
from tasks import ALE, task

from atari import AtariEnv, AtariVectorEnv
from atari.cores import snapshot
from atari.cores.ale_random import AleRandom
from atari.wrappers import DqnPreprocessing, NoopReset
from atari.wrappers.layers import AleSeeding, wrap

INFO = ("lives", "episode_frame_number", "frame_number")


def made(game: str = "breakout", probability: float = 0.0, **fields: Any) -> Any:
    env = AtariEnv(game, frameskip=1, repeat_action_probability=probability)
    return wrap(env, task(**{**ALE, **fields}))


@pytest.mark.parametrize(("game", "noop_max"), [("breakout", 1), ("breakout", 30), ("ms_pacman", 6), ("ms_pacman", 30)])
def test_starts_and_sticky_actions_are_ale_pys(game: str, noop_max: int) -> None:
    theirs = ale_py.AtariVectorEnv(game, 1, noop_max=noop_max, repeat_action_probability=0.25, reward_clipping=False)
    ours = made(game, 0.25, noops=(0, noop_max - 1), max_frames=108_000)
    rng = np.random.default_rng(0)
    for seed in (0, 1, 5, 2**31 - 1, None, None):
        expected, info = theirs.reset(seed=seed)
        observation, own = ours.reset(seed=seed)
        for _ in range(10):
            np.testing.assert_array_equal(observation, expected[0])
            assert [own[key] for key in INFO] == [info[key][0] for key in INFO]
            action = int(rng.integers(ours.action_space.n))
            expected, reward, *_, info = theirs.step(np.array([action]))
            observation, own_reward, *_, own = ours.step(action)
            assert own_reward == reward[0]


@pytest.mark.parametrize("frameskip", [(2, 5), (1, 3), (3, 4), 3])
def test_frame_skips_are_the_vectors(frameskip: Any) -> None:
    vector = AtariVectorEnv("breakout", 1, frameskip=frameskip, reward_clipping=False)
    single = made(frameskip=frameskip, max_frames=108_000)
    for seed in (3, None, 4):
        expected, info = vector.reset(seed=seed)
        observation, own = single.reset(seed=seed)
        for _ in range(30):
            np.testing.assert_array_equal(observation, expected[0])
            assert own["frame_number"] == info["frame_number"][0]
            expected, *_, info = vector.step(np.array([2]))
            observation, *_, own = single.step(2)


def test_a_number_of_no_ops_is_drawn_also_if_only_one_is_possible() -> None:
    env = made(noops=(3, 3), fire="never", fire_counts=False)
    env.reset(seed=11)
    generator = AleRandom(11)
    generator.below(1)
    assert env.unwrapped.driver.draw(5, 1005) == 5 + generator.below(1000)


def test_a_skip_of_one_length_draws_nothing() -> None:
    env = made(frameskip=(3, 4))
    env.reset(seed=11)
    before = env.unwrapped.driver.ale_random.state()
    env.step(2)
    assert env.unwrapped.driver.ale_random.state() == before


def test_a_seed_is_the_emulators() -> None:
    env = AleSeeding(AtariEnv("breakout"))
    plain = AtariEnv("breakout")
    seeds, others = (each.reset(seed=77)[1]["seeds"] for each in (env, plain))
    assert seeds == (others[0], 77)
    assert env.unwrapped.ale_settings.seed() == 77
    assert env.np_random.random() == plain.np_random.random(), "other wrappers draw as ever"


@pytest.mark.parametrize("seed", [2**32 + 5, 2**40 + 5])
def test_the_lowest_32_bits_of_a_seed_count(seed: int) -> None:
    one, other = (AleSeeding(AtariEnv("breakout", repeat_action_probability=0.5)) for _ in range(2))
    assert one.reset(seed=seed)[1]["seeds"][1] == other.reset(seed=5)[1]["seeds"][1] == 5
    for step in range(30):
        assert np.array_equal(one.step(step % 4)[0], other.step(step % 4)[0])


def played(env: Any, steps: int = 60) -> list[Any]:
    results = [env.reset()]
    for step in range(steps):
        results.append(env.step(step % 4))
        if results[-1][2] or results[-1][3]:
            results.append(env.reset())
    for result in results:
        result[-1].get("episode", {}).pop("t", None)  # seconds
    return results


FIELDS: dict[str, Any] = {"frameskip": (1, 5), "episodic_life": True}


def test_a_copy_has_a_generator_of_its_own() -> None:
    env = made(**FIELDS)
    env.reset(seed=5)
    twin = copy.copy(env.unwrapped)
    before = twin.snapshot()
    played(env)
    assert twin.snapshot() == before


def test_a_snapshot_of_the_other_seeding_is_refused() -> None:
    ale, plain = AleSeeding(AtariEnv("pong")).unwrapped, AtariEnv("pong")
    for env, other, texts in ((ale, plain, ("gymnasium", "ale")), (plain, ale, ("ale", "gymnasium"))):
        before = env.snapshot()
        with pytest.raises(ValueError, match="taken with seeding = '{}', but this environment has '{}'".format(*texts)):
            env.restore(other.snapshot())
        assert env.snapshot() == before


@pytest.mark.parametrize("state", [b"", bytes(2500), None])
def test_a_forged_generator_is_refused(state: bytes | None) -> None:
    env = made()
    env.reset(seed=1)
    inner = env.unwrapped
    before = inner.snapshot()
    facts, blobs = snapshot.unpack(before)
    del blobs["ale_random"]
    forged = snapshot.pack(facts, blobs if state is None else {**blobs, "ale_random": state})
    with pytest.raises(ValueError, match="ale_random"):
        inner.restore(forged)
    assert inner.snapshot() == before


def test_other_environments_draw_from_numpys_generator() -> None:
    env = AtariEnv("pong", frameskip=(2, 5))
    env.reset(seed=6)
    twin = copy.deepcopy(env.np_random)
    assert [env.driver.draw(2, 5) for _ in range(9)] == [int(twin.integers(2, 5)) for _ in range(9)]
    assert "seeding" not in snapshot.unpack(env.snapshot())[0]


def test_a_state_of_atari_play_keeps_the_generator(tmp_path: Any) -> None:
    """Such a state has none."""
    played_env = AtariEnv("pong", frameskip=1)
    played_env.reset(seed=3)
    state = snapshot.pack({"of": "play"}, {"env": played_env.snapshot()})
    env = DqnPreprocessing(NoopReset(AleSeeding(AtariEnv("pong", frameskip=1))))
    env.reset(seed=4)
    before = env.unwrapped.driver.ale_random.state()
    env.unwrapped.restore(state)
    assert env.unwrapped.driver.ale_random.state() == before
    np.testing.assert_array_equal(env.unwrapped.core.ram(), played_env.core.ram())
