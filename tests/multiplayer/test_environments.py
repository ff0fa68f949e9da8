"""PettingZoo's own tests, and the mistakes that users make."""

from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("pettingzoo")
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test

from atari import AtariEnv
from atari.cores import snapshot
from atari.multiplayer import ENVIRONMENTS, env, parallel_env
from atari.multiplayer.parallel import MultiplayerEnv

NAMES = [environment.id for environment in ENVIRONMENTS.values()]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("ignore")
def test_pettingzoos_tests_pass(name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    api_test(env(name, obs_type="ram"), num_cycles=20, verbose_progress=False)
    parallel_api_test(parallel_env(name, obs_type="ram"), num_cycles=20)
    seed_test(lambda: env(name, obs_type="ram"), num_cycles=10)
    parallel_seed_test(lambda: parallel_env(name, obs_type="ram"), num_cycles=10)
    render_test(lambda render_mode: env(name, render_mode=render_mode), {"human": lambda *_: True})


@pytest.mark.parametrize("name", ["pong", "pong_v3", "pong-v3", "atari/pong-v3"])
def test_names_are_accepted_in_all_spellings(name: str) -> None:
    assert parallel_env(name).metadata["name"] == "pong_v3"


def test_equal_seeds_give_equal_games_also_seed_zero() -> None:
    first, second = MultiplayerEnv("combat_tank", obs_type="ram"), MultiplayerEnv("combat_tank", obs_type="ram")
    for seed in (0, 1, 2**40):
        one, two = first.reset(seed=seed)[0], second.reset(seed=seed)[0]
        assert np.array_equal(one["first_0"], two["first_0"])


WRONG: tuple[Any, ...] = (None, "x", -1, 1.5, True, [], {}, [[]], ["third_0"], ["second_0", "first_0"], ["first_0"] * 2)


@pytest.mark.parametrize("options", [{}, {"obs_type": "ram"}, {"obs_type": "grayscale", "stack_num": 2}])
def test_a_foreign_or_damaged_snapshot_is_refused_and_changes_nothing(options: dict[str, Any]) -> None:
    game = MultiplayerEnv("pong", **options)
    game.reset(seed=0)
    game.step({"first_0": 1})
    good = game.snapshot()
    facts, blobs = snapshot.unpack(good)
    forged = [
        *(
            ({**facts, name: wrong}, blobs)
            for name in ("of", "agents")
            for wrong in WRONG
            if (name, wrong) != ("agents", [])
        ),
        *(({**facts, "task": wrong}, blobs) for wrong in WRONG),
        *((facts, {name: blobs[name]}) for name in blobs),
        *(
            (facts, {**blobs, name: wrong})
            for name in blobs
            for wrong in (b"", b"x", blobs[name][:-1], blobs[name] + b"x")
        ),
        (facts, {**blobs, "core": MultiplayerEnv("pong", num_players=4).core.snapshot()}),
    ]
    others = [MultiplayerEnv("boxing").snapshot(), AtariEnv("pong").snapshot(), game.core.snapshot()]
    damaged = [b"", b"x", good[:-1], good + b"x", good[:-1] + bytes([good[-1] ^ 1])]
    for data in (None, "x", 3, (), [good], *damaged, *others, *(snapshot.pack(*each) for each in forged)):
        with pytest.raises((TypeError, ValueError), match=r"snapshot|the task is damaged|the state "):
            game.restore(data)
        assert game.snapshot() == good
    for agents in (["second_0"], []):
        game.restore(snapshot.pack({**facts, "agents": agents}, blobs))
        assert game.agents == agents
        assert list(game.step({})[0]) == agents


@pytest.mark.parametrize("fill", [0, 0xFF])
def test_a_snapshot_with_a_forged_episode_is_played_without_a_crash(fill: int) -> None:
    game = MultiplayerEnv("warlords", players=4, preset="multiplayer_dqn", frameskip=(2, 5), noops=(0, 9))
    game.reset(seed=0)
    facts, blobs = snapshot.unpack(game.snapshot())
    blobs["episode"] = bytes([fill]) * len(blobs["episode"])
    game.restore(snapshot.pack({**facts, "agents": []}, blobs))
    assert game.step({}) == ({}, {}, {}, {}, {})
    assert game.terminations == dict.fromkeys(game.possible_agents, fill > 0)
    if not fill:
        game.restore(snapshot.pack(facts, blobs))
        assert list(game.step({})[0]) == game.possible_agents
    assert list(game.reset()[0]) == game.agents == game.possible_agents


def test_games_without_an_environment_of_pettingzoos_have_one_here() -> None:
    game = MultiplayerEnv("fishing_derby", obs_type="grayscale_image", frameskip=4)
    observations, _ = game.reset(seed=1)
    assert observations["second_0"].shape == (210, 160, 1)
    assert game.metadata["name"] == "custom_fishing_derby"


def test_actions_follow_pettingzoos_conventions() -> None:
    game = parallel_env("joust")
    game.reset(seed=1)
    with pytest.raises(KeyError):
        game.step({"first_0": 0})
    game = parallel_env("joust")
    game.reset(seed=1)
    with pytest.raises(AssertionError):
        game.step({"first_0": 0, "second_0": 99})
    game = parallel_env("joust", max_cycles=1)
    game.reset(seed=1)
    game.step({"first_0": 0, "second_0": 0})
    assert game.step({}) == ({}, {}, {}, {}, {})


def test_rendering_without_a_mode_warns() -> None:
    game = MultiplayerEnv("pong")
    with pytest.warns(UserWarning, match="render_mode"):
        assert game.render() is None


def test_without_pettingzoo_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'pettingzoo>=1\.25'"):
        parallel_env("pong")
