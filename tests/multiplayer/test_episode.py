"""`_emulator.Episode` for several players: rewards, players who are out, cores that Python plays, and errors."""

from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import Any

import numpy as np
import pytest

import atari._emulator as _emulator
from atari import Task
from atari.cores import NativeCore
from atari.cores.compiled import reward_formula
from atari.env.settings import filled_by_name, make_episode, observation_settings
from atari.multiplayer import MultiplayerCore

FOUR: dict[str, Any] = {"game": "warlords", "players": 4, "obs_type": "ram", "frameskip": 1, "reward_clipping": False}
SEED = [5, 1, 2, 3, 4, 5, 6, 7, 8]


class Scripted:
    """A core in Python for four players: the lives of each player by frame, and a reward of 10 for each action."""

    game_over = truncated = False
    RAM, SCREEN = np.zeros(128, np.uint8), np.zeros((210, 160), np.uint8)

    def __init__(self, lives: Sequence[tuple[int, ...]] = ((0, 0, 0, 0),)) -> None:
        self.lives_by_frame, self.played = lives, []  # type: ignore[var-annotated]

    @property
    def frame_number(self) -> int:
        return len(self.played)

    episode_frame_number = frame_number

    @property
    def player_lives(self) -> list[int]:
        return [*self.lives_by_frame[min(len(self.played), len(self.lives_by_frame) - 1)]]

    def reset(self) -> None:
        self.played = []

    def act_players(self, actions: Sequence[int]) -> list[int]:
        self.played.append(tuple(actions))
        return [10 * action for action in actions]

    def ram(self) -> Any:
        return self.RAM

    def screen(self) -> Any:
        return self.SCREEN


def beginning(core: Any) -> Callable[[], Any]:
    """A function that begins a game of the core, and returns the core."""

    def begin() -> Any:
        core.reset()
        return core

    return begin


def of_four(**fields: Any) -> _emulator.Episode:
    """The episode of a task of four players, whose idle actions are 11 to 14."""
    return make_episode(Task(**{**FOUR, **fields}), idle=[11, 12, 13, 14])


def begun(core: Any, **fields: Any) -> _emulator.Episode:
    episode = of_four(**fields)
    episode.reset(core, beginning(core))
    return episode


def test_each_player_has_an_action_a_reward_and_lives() -> None:
    core = Scripted([(0, 1, 2, 3)])
    episode = of_four(frameskip=2)
    _, info = episode.reset(core, beginning(core))
    assert (info["lives"], info["out"], info["reward"]) == ((0, 1, 2, 3), (False,) * 4, (0.0,) * 4)
    observation, rewards, terminated, truncated, info = episode.step(core, [1, 2, 3, 4])
    assert core.played == [(1, 2, 3, 4)] * 2
    assert (rewards, terminated, truncated) == ((20.0, 40.0, 60.0, 80.0), False, False)
    assert (info["reward"], info["elapsed_step"], episode.steps, episode.score) == (rewards, 1, 1, (20, 40, 60, 80))
    assert observation.shape == (128,)


def test_rewards_of_all_players_are_clipped() -> None:
    episode = begun(core := Scripted(), reward_clipping=True)
    _, rewards, *_, info = episode.step(core, (0, 2, 3, 4))
    assert (rewards, info["reward"]) == ((0.0, 1.0, 1.0, 1.0), (0.0, 20.0, 30.0, 40.0))


def test_a_player_who_is_out_takes_the_idle_action_from_the_next_step_on_and_gets_nothing() -> None:
    core = Scripted([(0, 0, 0, 0)] * 2 + [(0, -1, 0, 0)] + [(0, 0, 0, 0)])
    episode = begun(core, frameskip=3)
    _, rewards, *_, info = episode.step(core, [1, 2, 3, 4])
    assert (rewards, info["out"]) == ((30.0, 60.0, 90.0, 120.0), (False, True, False, False))
    _, rewards, terminated, *_, info = episode.step(core, [1, 2, 3, 4])
    assert core.played == [(1, 2, 3, 4)] * 3 + [(1, 12, 3, 4)] * 3
    assert (rewards, terminated) == ((30.0, 0.0, 90.0, 120.0), False)
    assert info["out"] == episode.out == (False, True, False, False)
    _, info = episode.reset(core, beginning(core))
    assert info["out"] == episode.out == (False,) * 4


def test_an_episode_ends_when_all_players_are_out() -> None:
    core = Scripted([(0, 0, 0, 0), (-1, 0, 0, 0), (0, -1, 0, 0), (0, 0, -1, -1)])
    episode = begun(core)
    assert [episode.step(core, [0] * 4)[2] for _ in range(3)] == [False, False, True]


def test_a_function_sees_the_frames_of_all_players() -> None:
    episode, seen = begun(core := Scripted(), frameskip=2), []
    episode.step(core, [1, 2, 3, 4], 1.0, lambda *frame: seen.append(frame))
    assert seen == [((1, 2, 3, 4), (10, 20, 30, 40))] * 2


class Swapped(MultiplayerCore):
    """Plays the actions of the two players the other way round."""

    def act_players(self, actions: Sequence[int]) -> list[int]:
        return super().act_players([actions[1], actions[0]])[::-1]


def swapped(method: Any) -> Any:
    """A method that plays the actions the other way round, with the attributes of the one that it wraps."""

    @wraps(method)
    def call(core: Any, actions: Sequence[int]) -> Any:
        return method(core, [actions[1], actions[0]])[::-1]

    return call


class Decorated(MultiplayerCore):
    act_players = swapped(MultiplayerCore.act_players)


class WithoutFrameNumber(MultiplayerCore):
    @property
    def frame_number(self) -> int:
        raise RuntimeError("the core is played by its methods")


def play(core_type: type[MultiplayerCore], swapped: bool = False) -> list[Any]:
    """Random steps on a core of this type, with the results of both players the other way round if `swapped`."""
    core = core_type("boxing", repeat_action_probability=0.0)
    episode = make_episode(Task("boxing", players=2, obs_type="grayscale", stack_num=2, noops=(3, 9)), idle=[0, 0])
    order = slice(None, None, -1 if swapped else 1)
    observation, _ = episode.reset(core, beginning(core), seed=SEED)
    results: list[Any] = [observation.tobytes()]
    for actions in np.random.default_rng(0).integers(0, 18, (150, 2)).tolist():
        observation, rewards, *ends, info = episode.step(core, actions[order])
        results.append((observation.tobytes(), rewards[order], ends, info["lives"][order], core.save()))
    return results


@pytest.mark.parametrize("core_type", [Swapped, Decorated])
def test_a_subclass_is_played_by_its_own_act_players(core_type: type[MultiplayerCore]) -> None:
    assert play(core_type, swapped=True) == play(MultiplayerCore) != play(MultiplayerCore, swapped=True)


def test_a_core_of_the_package_is_played_without_its_methods() -> None:
    assert play(WithoutFrameNumber) == play(MultiplayerCore)


def test_the_seed_of_an_episode_is_that_of_a_reset() -> None:
    task = Task("pong", players=2, obs_type="ram", noops=(0, 30), frameskip=(2, 9))
    frames = []
    for given, later in ((SEED, None), (None, SEED), (SEED[::-1], None)):
        core = MultiplayerCore("pong")
        episode = make_episode(task, idle=[0, 0], seed=given)
        episode.reset(core, beginning(core), seed=later)
        frames.append([core.frame_number, *(episode.step(core, [0, 0])[4]["frame_number"] for _ in range(9))])
    assert frames[0] == frames[1] != frames[2]


def test_the_present_observation_is_that_of_the_last_call() -> None:
    core = MultiplayerCore("pong")
    episode = make_episode(Task("pong", players=2, obs_type="rgb_dict", frameskip=4), idle=[0, 0])
    present: Any = episode.observation
    assert not any(part.any() for part in present.values())
    for play_on in (partial(episode.reset, core, beginning(core)), partial(episode.step, core, [2, 3])):
        observation, present = play_on()[0], episode.observation
        assert observation.keys() == present.keys()
        assert all(np.array_equal(part, present[name]) for name, part in observation.items())


WRONG: dict[str, tuple[Any, type[Exception], str]] = {
    "too few actions": ([0, 0], ValueError, r"an action of each of 4 players, got \[0, 0\]"),
    "too many actions": ([0] * 5, ValueError, "an action of each of 4 players"),
    "one number": (0, TypeError, "an action of each of 4 players, got 0"),
    "a mapping": ({0: 0}, TypeError, "an action of each of 4 players"),
    "no ALE number": ([0, 18, 0, 0], ValueError, "within 0..17, got 18"),
    "a text": ([0, "x", 0, 0], TypeError, "an action is an integer 0..17, got 'x'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_actions_are_refused_and_play_nothing(case: str) -> None:
    actions, error, words = WRONG[case]
    episode = begun(core := Scripted())
    before = episode.save()
    with pytest.raises(error, match=words):
        episode.step(core, actions)
    assert (core.played, episode.save()) == ([], before)


class Fails(Scripted):
    def act_players(self, actions: Sequence[int]) -> list[int]:
        raise OSError("the disk is full")


class PaysTwo(Scripted):
    def act_players(self, actions: Sequence[int]) -> list[int]:
        return super().act_players(actions)[:2]


class LivesOfTwo(Scripted):
    player_lives = (0, 0)  # type: ignore[assignment]


@pytest.mark.parametrize(
    ("core", "error", "words"),
    [
        (Fails(), OSError, "the disk is full"),
        (PaysTwo(), TypeError, "the core's act_players must have a number of each player, got"),
        (LivesOfTwo(), TypeError, "the core's player_lives must have a number of each player, got"),
        (MultiplayerCore("combat"), ValueError, "the rules of this core's game are not for 4 players"),
        (NativeCore("pong", seed=0), ValueError, "the rules of this core's game are not for 4 players"),
    ],
)
def test_an_error_of_a_core_is_raised_and_the_episode_goes_on_with_another(
    core: Any, error: type[Exception], words: str
) -> None:
    episode = begun(good := Scripted())
    with pytest.raises(error, match=words):
        episode.step(core, [0] * 4)
    assert episode.step(good, [1, 2, 3, 4])[1] == (10.0, 20.0, 30.0, 40.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"idle": [0, 0]}, "an idle action of each player"),
        ({"idle": [0, 0, 0, 18]}, r"within 0\.\.17"),
        ({"begin_actions": [0, 1, -1]}, r"within 0\.\.17"),
        ({"settings": {"episodic_life": True}}, "FIRE and lost lives are settings of one player"),
        ({"settings": {"players": 5}}, "there are 1 to 4 players"),
        ({"reward": True}, "for one player"),
    ],
)
def test_an_impossible_episode_is_refused(changes: dict[str, Any], words: str) -> None:
    task = Task(**FOUR)
    changed = changes.get("settings", {})
    settings = filled_by_name(_emulator.EpisodeSettings(), task, acts_after_end=False, **changed)
    with pytest.raises(ValueError, match=words):
        _emulator.Episode(
            settings,
            observation_settings(task),
            rows=210,
            format="NTSC",
            begin_actions=changes.get("begin_actions", [0]),
            idle=changes.get("idle", [0] * 4),
            reward=reward_formula(task.definition, "reward") if "reward" in changes else None,
        )


@pytest.mark.parametrize("fill", [0, 1, 0x7F, 0x80, 0xFF])
def test_a_forged_state_is_played_without_a_crash(fill: int) -> None:
    task = Task("warlords", players=4, noops=(0, 30), frameskip=(2, 5), obs_type="grayscale", stack_num=3)
    core = MultiplayerCore("warlords", players=4)
    episode = make_episode(task, idle=[0] * 4)
    size = len(episode.save())
    for wrong in (b"", bytes(size - 1), bytes(size + 1)):
        with pytest.raises(ValueError, match=f"the state of this episode has {size} bytes, got {len(wrong)}"):
            episode.load(wrong)
    episode.load(bytes([fill]) * size)
    assert len(episode.out) == 4
    for _ in range(4):
        episode.step(core, [1, 2, 3, 4])
    _, info = episode.reset(core, beginning(core))
    assert info["out"] == (False,) * 4
    episode.step(core, [1, 2, 3, 4])
