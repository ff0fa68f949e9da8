"""A task of several players is `MultiplayerEnv`, and the lane of a vector: the same bytes for every field."""

import random
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pettingzoo")
from field_values import CASES, lacking, seconds_of_step, settled, small, value_of
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st
from vector_tools import as_bytes

import atari
from atari import Task
from atari.multiplayer.parallel import MultiplayerEnv
from atari.testing.contract import difference

OF_SEVERAL = tuple(name for name in CASES if name not in lacking("several"))
"""The fields of a task of several players."""
GAMES = (("pong", 2), ("pong", 4), ("warlords", 4), ("joust", 2), ("boxing", 2), ("wizard_of_wor", 2), ("combat", 2))


@st.composite
def tasks(draw: st.DrawFn) -> Task:
    """A random task of several players."""
    name, players = draw(st.sampled_from(GAMES))
    game, source = atari.games[name], random.Random(draw(st.integers(0, 2**32 - 1)))
    names = {*OF_SEVERAL} - {"game", "players", "mode", "difficulty"}
    drawn = {field: value_of(source, field, game, small) for field in sorted(names) if source.random() < 0.5}
    task = settled(source, game, {**drawn, "players": players})
    assume(task is not None and seconds_of_step(task) < 0.02)
    assert task is not None
    return task


def vector(task: Task) -> atari.AtariVectorEnv:
    """A vector of one lane, with the layout of `MultiplayerEnv`."""
    last = task.stack_num is not None and task.obs_type != "ram"
    return atari.AtariVectorEnv(task, 1, num_threads=1, autoreset_mode="Disabled", channels_last=last)


def of_player(batch: Any, player: int | None) -> Any:
    """The observation of a player, or that of all."""
    if isinstance(batch, dict):
        return {name: of_player(part, player) for name, part in batch.items()}
    return batch[0] if player is None else batch[0, player]


class Pair:
    """A `MultiplayerEnv` beside the lane of a vector."""

    def __init__(self, task: Task) -> None:
        self.envs, self.game = vector(task), MultiplayerEnv(task)
        assert self.game.task == task == self.envs.task
        for agent in self.game.possible_agents:
            space = self.envs.single_observation_space
            assert self.game.observation_space(agent) == space or task.agent_indicator

    def reset(self, seed: int | None) -> None:
        """Reset both, and compare."""
        batch, _ = self.envs.reset(seed=seed)
        observations, infos = self.game.reset(seed=seed)
        assert infos == {agent: {} for agent in self.game.possible_agents}
        self.same(observations, batch)

    def step(self, source: np.random.Generator) -> bool:
        """A step of both; whether the episode has ended."""
        agents = list(self.game.agents)
        indices = source.integers(self.envs.single_action_space.nvec)
        batch, rewards, terminated, truncated, info = self.envs.step(indices[None])
        actions = dict(zip(self.game.possible_agents, map(int, indices), strict=True))
        seen, paid, over, cut, _ = self.game.step({agent: actions[agent] for agent in agents})
        assert list(seen) == list(paid) == list(over) == list(cut) == agents
        self.same(seen, batch)
        for player, agent in enumerate(self.game.possible_agents):
            if agent not in agents:
                assert rewards[0, player] == 0 or self.game.task.zero_sum
                continue
            assert (paid[agent], over[agent], cut[agent]) == (
                rewards[0, player],
                terminated[0, player],
                truncated[0, player],
            )
        assert self.game.core.frame_number == info["frame_number"][0]
        return bool((terminated | truncated).all())

    def same(self, observations: dict[str, Any], batch: Any) -> None:
        """Whether what each agent sees is in the batch, and the RAM is equal."""
        for player, agent in enumerate(self.game.possible_agents):
            if agent in observations:
                own = of_player(batch, player if self.game.task.agent_indicator else None)
                assert difference(own, observations[agent], "observation") is None
                space = self.game.observation_space(agent)
                assert space.contains(observations[agent])
        assert self.game.core.ram().tolist() == self.envs.ram()[0].tolist()


@given(tasks(), st.integers(0, 2**32 - 1))
@example(Task.of("warlords", players=4, preset="multiplayer_dqn", agent_indicator=True), 3)
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
def test_a_parallel_environment_is_the_lane_of_a_vector(task: Task, seed: int) -> None:
    pair, source = Pair(task), np.random.default_rng(seed)
    pair.reset(seed)
    taken: Any = None
    for step in range(40):
        if pair.step(source):
            pair.reset(None)
        if step == 14:
            taken = pair.envs.snapshot(), pair.game.snapshot()
        if step == 20:
            pair.envs.restore(None, taken[0])
            pair.game.restore(taken[1])
    pair.envs.close()


@pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
def test_a_game_that_ends_in_the_no_ops_begins_again_with_the_seed(seeding: str) -> None:
    task = Task("pong", players=2, noops=(20, 20), max_num_frames_per_episode=9, frameskip=(2, 5), seeding=seeding)
    pair, source = Pair(task), np.random.default_rng(0)
    for seed in (0, None, 3):
        pair.reset(seed)
        assert pair.game.core.frame_number == pair.envs.lanes[0].frame_number
        while not pair.step(source):
            pass
    pair.envs.close()


def test_players_who_are_out_are_those_of_the_lane() -> None:
    pair = Pair(Task.of("warlords", players=4, obs_type="ram", frameskip=4))
    pair.reset(3)
    source, left = np.random.default_rng(0), set()
    for _ in range(3000):
        if pair.step(source):
            pair.reset(None)
        left.add(len(pair.game.agents))
    assert left >= {2, 3, 4}


def trace(task: Task) -> Iterator[Any]:
    """All that agents get in some steps of random actions."""
    game, source = MultiplayerEnv(task), np.random.default_rng(3)
    observations, _ = game.reset(seed=5)
    yield str(game.action_spaces), [as_bytes(one) for one in observations.values()]
    for _ in range(220):
        actions = {agent: int(source.integers(game.action_space(agent).n)) for agent in game.agents}
        observations, *ends, _ = game.step(actions)
        numbers = [{agent: float(value) for agent, value in part.items()} for part in ends]
        yield [as_bytes(one) for one in observations.values()], numbers
        if any(ends[2].values()) or not game.agents:
            game.reset()


@pytest.mark.parametrize("field", OF_SEVERAL)
def test_every_field_acts(field: str) -> None:
    case = CASES[field].several or CASES[field]
    others = {"game": "pong", "players": 2, **case.needs, **case.seen}
    one, other = Task(**others), Task(**{**others, field: case.value})
    assert field in one.differences(other)
    assert any(mine != theirs for mine, theirs in zip(trace(one), trace(other), strict=True))


@pytest.mark.parametrize("field", [name for name in lacking("several") if not CASES[name].needs])
def test_a_field_of_one_player_is_refused(field: str) -> None:
    with pytest.raises(ValueError, match=f"{field}.*for one player"):
        MultiplayerEnv("pong", **{field: CASES[field].value})
