"""Each field of the engine's episodes has its effect, however the layers of an episode are nested."""

from typing import Any
from unittest import mock

import numpy as np
import pytest

import atari
import atari._emulator as _emulator
from atari.env.settings import episode_settings, filled_by_name
from atari.task import Task
from atari.task.fields import FIELDS
from atari.task.task import look_up

BASE: dict[str, Any] = {
    "repeat_action_probability": 0.0,
    "on_reset": "continue",
    "max_num_frames_per_episode": None,
    "img_height": 84,
    "img_width": 84,
    "stack_num": 4,
    "maxpool": True,
    "padding": "reset",
}
"""Episodes that begin without no-ops and FIRE, and end when the game is over."""

LIVES: dict[str, dict[str, Any]] = {
    "lives and FIRE of frames": {"lives_unit": "frame", "fire_unit": "frame"},
    "lives of frames, FIRE of skips": {"lives_unit": "frame", "fire_unit": "skip"},
    "lives of skips, FIRE of frames": {"lives_unit": "skip", "fire_unit": "frame"},
    "lives and FIRE of skips": {"lives_unit": "skip", "fire_unit": "skip"},
}
NESTINGS = {name: {"episodic_life": True, "fire": "after_noops", **units} for name, units in LIVES.items()}
"""The order of the layers where no-ops come first."""

SEAMLESS: dict[str, Any] = {"episodic_life": True, "seamless_lives": True, "frameskip": 1, "maxpool": False}

of_every_nesting = pytest.mark.parametrize("nesting", NESTINGS.values(), ids=NESTINGS)


def make(game: str = "breakout", **fields: Any) -> atari.AtariVectorEnv:
    """One environment whose engine has these fields, and otherwise those of `BASE`."""
    return atari.AtariVectorEnv(look_up(game).task(None, {}, {**BASE, **fields}), 1, num_threads=1)


class Player:
    """Plays one environment and keeps what the last step gave."""

    def __init__(self, game: str = "breakout", seed: int = 3, **fields: Any) -> None:
        self.envs = make(game, **fields)
        self.reset(seed=seed)

    def reset(self, **arguments: Any) -> None:
        observation, info = self.envs.reset(**arguments)
        self._keep(observation, False, False, info)

    def step(self, action: int = 0) -> None:
        """The step after an end resets, as the mode `NextStep` has it."""
        observation, _, terminated, truncated, info = self.envs.step(np.array([action]))
        self._keep(observation, bool(terminated[0]), bool(truncated[0]), info)

    def _keep(self, observation: Any, terminated: bool, truncated: bool, info: dict[str, Any]) -> None:
        self.observation, self.info = observation[0].copy(), info
        self.terminated, self.truncated = terminated, truncated
        self.frames, self.lives = int(info["episode_frame_number"][0]), int(info["lives"][0])

    def lose_life(self, action: int = 1) -> int:
        """Play until a life is lost; returns how many frames the last step played."""
        lives, frames = self.lives, self.frames
        while self.lives >= lives:
            assert not self.terminated
            frames = self.frames
            self.step(action)
        return self.frames - frames

    @property
    def ram(self) -> list[int]:
        return self.envs.lanes[0].ram().tolist()  # type: ignore[no-any-return]


def ram_after(actions: list[int], game: str = "breakout", seed: int = 3) -> list[int]:
    """The RAM after single frames of ALE's actions."""
    env = atari.AtariEnv(game, frameskip=1, repeat_action_probability=0.0)
    env.reset(seed=seed)
    for action in actions:
        env.driver.play_frames(action, frames=1)
    return env.core.ram().tolist()  # type: ignore[no-any-return]


def below(words: Any, limit: int) -> list[int]:
    """What `MersenneTwister.below` makes of words, but for one in a billion."""
    return [int(word) * limit >> 32 for word in words]


def twister(seed: int, count: int) -> Any:
    """The first words of the Mersenne Twister of this seed."""
    return np.frombuffer(np.random.RandomState(seed).bytes(4 * count), "<u4")


class TestTheFrameSkip:
    @of_every_nesting
    def test_is_drawn_from_numpys_generator_at_each_step(self, nesting: dict[str, Any]) -> None:
        player = Player(frameskip=(2, 7), **{**nesting, "fire": "never"})
        env = atari.AtariEnv("breakout")
        env.reset(seed=3)
        for _ in range(30):
            frames = player.frames
            player.step()
            assert player.frames - frames == env.np_random.integers(2, 7)

    def test_is_drawn_from_ales_generator(self) -> None:
        player = Player(frameskip=(2, 7), seeding="ale")
        seen = []
        for _ in range(30):
            frames = player.frames
            player.step()
            seen.append(player.frames - frames)
        assert seen == [2 + number for number in below(twister(3, 31)[1:], 5)]  # the first word is of the no-ops


class TestNoops:
    @pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
    def test_are_drawn_from_both_ends(self, seeding: str) -> None:
        assert {Player(noops=(20, 22), seeding=seeding, seed=seed).frames for seed in range(40)} == {20, 21, 22}

    def test_of_one_number_draw_a_word_of_ales_generator(self) -> None:
        player = Player(noops=(5, 5), frameskip=(2, 7), seeding="ale")
        assert player.frames == 5
        player.step()
        assert player.frames == 5 + 2 + below(twister(3, 2)[1:], 5)[0]

    @pytest.mark.parametrize("fire", ["before_noops", "after_noops"])
    def test_may_include_fire(self, fire: str) -> None:
        assert Player(noops=(8, 8), fire=fire, fire_counts=True).frames == 8
        assert Player(noops=(8, 8), fire=fire).frames == 9
        assert Player("freeway", noops=(8, 8), fire=fire, fire_counts=True).frames == 8  # without FIRE

    def test_that_lose_a_life_go_on_after_a_reset(self) -> None:
        """A ball of Breakout is lost after 96 no-ops. The reset is that of a lost life, and presses FIRE again."""
        player = Player(fire="before_noops", noops=(150, 150), episodic_life=True)
        assert (player.lives, player.frames) == (5, 150 - 96 + 1)  # With a seed, it begins a new game.
        player.reset()
        assert (player.lives, player.frames) == (4, 150 + 2)

    @pytest.mark.parametrize("unit", ["frame", "skip"])
    def test_of_games_without_noop_are_frames_of_it(self, unit: str) -> None:
        player = Player("backgammon", noops=(5, 5), episodic_life=True, lives_unit=unit)
        assert player.ram == ram_after([0] * 5, "backgammon")


class TestFire:
    @pytest.mark.parametrize(
        ("fields", "actions"),
        [
            ({"fire": "never"}, [0] * 3),
            ({"fire": "never", "fire_unit": "skip"}, [0] * 3),
            ({"fire": "before_noops"}, [1, 0, 0, 0]),
            ({"fire": "after_noops"}, [0, 0, 0, 1]),
            ({"fire": "before_noops", "third_action": True}, [1, 3, 0, 0, 0]),
            ({"fire": "after_noops", "third_action": True}, [0, 0, 0, 1, 3]),
            ({"fire": "after_noops", "fire_unit": "skip"}, [0] * 3 + [1] * 4),
            ({"fire": "after_noops", "fire_unit": "skip", "third_action": True}, [0] * 3 + [1] * 4 + [3] * 4),
        ],
    )
    @pytest.mark.parametrize("lives", [{}, {"episodic_life": True}, {"episodic_life": True, "lives_unit": "skip"}])
    def test_is_played_when_and_for_how_long_the_fields_say(
        self, fields: dict[str, Any], actions: list[int], lives: dict[str, Any]
    ) -> None:
        player = Player(noops=(3, 3), **fields, **lives)
        assert player.frames == len(actions)
        assert player.ram == ram_after(actions)

    @pytest.mark.parametrize(("again", "frames"), [(True, 8), (False, 6)])
    def test_may_be_pressed_again_after_a_game_that_ended_in_the_noops(self, again: bool, frames: int) -> None:
        """Games end after 10 frames: after FIRE and 9 of the 25 no-ops, then after 9 with FIRE, or 10 without."""
        player = Player(noops=(25, 25), fire="before_noops", fire_again=again, max_num_frames_per_episode=10)
        assert player.frames == frames

    def test_of_skips_fills_the_stack_with_its_last_image(self) -> None:
        player = Player(fire="after_noops", fire_unit="skip")
        assert all(np.array_equal(image, player.observation[3]) for image in player.observation)
        black = Player(fire="after_noops", fire_unit="skip", padding="zero").observation
        assert not black[:3].any()
        assert np.array_equal(black[3], player.observation[3])


class TestALostLife:
    @pytest.mark.parametrize("units", LIVES.values(), ids=LIVES)
    def test_ends_the_episode_at_its_frame_or_after_the_skip(self, units: dict[str, Any]) -> None:
        player = Player(episodic_life=True, **units)
        left = player.lose_life()
        assert player.terminated
        assert not player.truncated
        assert player.lives == 4
        assert left == 4 if units["lives_unit"] == "skip" else left < 4

    @pytest.mark.parametrize(
        ("on_reset", "unit", "frames"),
        [("noop", "frame", 1), ("noop", "skip", 4), ("continue", "frame", 0), ("continue", "skip", 0)],
    )
    def test_is_followed_by_what_on_reset_says(self, on_reset: str, unit: str, frames: int) -> None:
        player = Player(episodic_life=True, on_reset=on_reset, lives_unit=unit)
        player.lose_life()
        before, image = player.frames, player.observation[3]
        player.step()
        assert (player.frames, player.lives, player.terminated) == (before + frames, 4, False)
        assert frames or all(np.array_equal(old, image) for old in player.observation)

    @pytest.mark.parametrize("unit", ["frame", "skip"])
    def test_is_followed_by_a_new_game(self, unit: str) -> None:
        player = Player(episodic_life=True, on_reset="new_game", lives_unit=unit)
        player.lose_life()
        player.step()
        assert (player.frames, player.lives) == (0, 5)

    @pytest.mark.parametrize(
        ("lives_unit", "fire_unit", "frames"),
        [("frame", "frame", 1), ("frame", "skip", 4), ("skip", "frame", 0), ("skip", "skip", 4)],
    )
    def test_is_followed_by_fire_of_the_layers_outside(self, lives_unit: str, fire_unit: str, frames: int) -> None:
        player = Player(episodic_life=True, fire="after_noops", lives_unit=lives_unit, fire_unit=fire_unit)
        player.lose_life()
        before = player.frames
        player.step()
        assert player.frames - before == frames

    @of_every_nesting
    def test_is_forgotten_by_a_new_game_that_is_asked_for(self, nesting: dict[str, Any]) -> None:
        player = Player(**nesting)
        first = player.frames
        for arguments in ({"options": {"new_game": True}}, {"seed": 9}):
            player.lose_life()
            player.reset(**arguments)
            assert (player.frames, player.lives) == (first, 5)
        player.lose_life()
        player.reset()
        assert player.lives == 4

    @pytest.mark.parametrize("unit", ["frame", "skip"])
    @pytest.mark.parametrize("last_life", [True, False])
    def test_of_the_last_life_may_count(self, unit: str, last_life: bool) -> None:
        """Frogger goes on for a while after the last life."""
        player = Player("frogger", episodic_life=True, lives_unit=unit, last_life=last_life)
        while player.lives > 0:
            player.step(1)
        assert player.terminated == last_life
        assert not player.info["terminated"][0]

    def test_may_neither_cut_the_skip_nor_clear_the_stack(self) -> None:
        player = Player(episodic_life=True, seamless_lives=True)
        assert player.lose_life() == 4
        assert player.terminated
        before = player.observation
        player.step()
        assert np.array_equal(player.observation[:3], before[1:])


class TestDelays:
    """A lost life that clears no stack keeps what is on its way: the delayed game is the other one, some frames later."""

    def test_of_observations_go_on_over_a_lost_life(self) -> None:
        seen = []
        for delay in (0, 3):
            player = Player(**SEAMLESS, observation_delay=delay)
            images = {}
            while player.lives >= 4:
                player.step(1)
                images[player.frames] = player.observation[-1].tobytes()
            seen.append(list(images.values()))
        at_once, late = seen
        assert late[3:] == at_once[:-3]

    @pytest.mark.parametrize(("delay", "served"), [(0, False), (3, True)])
    def test_of_actions_go_on_over_a_lost_life(self, delay: int, served: bool) -> None:
        """A FIRE of the life before serves the ball of the next one, if it arrives late."""
        player = Player(**SEAMLESS, action_delay=delay)
        player.lose_life(action=1)
        for _ in range(20):
            player.step(2)
        assert (player.ram[atari.games["breakout"].ram_labels["ball_y"].index] != 0) is served


class TestLifeLossInfo:
    @pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
    @pytest.mark.parametrize("fire_unit", ["frame", "skip"])
    def test_reports_and_goes_on(self, seeding: str, fire_unit: str) -> None:
        player = Player(life_loss_info=True, seeding=seeding, fire="after_noops", fire_unit=fire_unit)
        for lives in (4, 3):
            assert player.lose_life() == 4
            assert (player.terminated, player.truncated, player.lives) == (True, False, lives)
            before = player.frames
            player.step()
            assert (player.terminated, player.frames - before) == (False, 4)

    @pytest.mark.parametrize("last_life", [True, False])
    def test_of_the_last_life(self, last_life: bool) -> None:
        player = Player("frogger", life_loss_info=True, last_life=last_life)
        while player.lives > 0:
            player.step(1)
        assert player.terminated == last_life
        assert not player.info["terminated"][0]

    def test_hides_a_truncation_as_in_ale_py(self) -> None:
        player = Player(life_loss_info=True)
        player.lose_life()
        limited = Player(life_loss_info=True, max_frames=player.frames)
        limited.lose_life()
        assert (limited.terminated, limited.truncated) == (True, False)
        limited.step()
        assert (limited.frames, limited.lives) == (0, 5)


class TestLimits:
    @pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
    @of_every_nesting
    def test_of_all_frames_of_a_game(self, nesting: dict[str, Any], seeding: str) -> None:
        player = Player(noops=(3, 3), max_num_frames_per_episode=41, seeding=seeding, **nesting)
        for _ in range(3):
            begun = player.frames
            while not player.truncated:
                assert player.frames < 41
                player.step()
            assert (player.frames, player.terminated) == (41, False)
            assert player.info["episode"]["l"][0] == 41
            player.step()
            assert player.frames == begun

    @pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
    @of_every_nesting
    def test_of_the_frames_after_the_beginning(self, nesting: dict[str, Any], seeding: str) -> None:
        """FIRE counts if it is played for a whole skip."""
        player = Player(noops=(3, 3), max_frames=10, seeding=seeding, **nesting)
        begin = 3 + (nesting["fire_unit"] == "frame")
        for _ in range(2):
            while not player.truncated:
                player.step()
            assert (player.frames, player.terminated) == (begin + 10, False)
            player.step()

    @of_every_nesting
    def test_of_frames_counts_on_after_a_lost_life(self, nesting: dict[str, Any]) -> None:
        player = Player(max_frames=150, **nesting)
        player.lose_life()
        while not player.truncated:
            player.step()
        presses = {"frame": 2, "skip": 1}[nesting["lives_unit"]]
        assert (player.frames, player.lives) == (150 + presses * (nesting["fire_unit"] == "frame"), 4)
        player.step()
        assert player.lives == 5

    @of_every_nesting
    def test_of_the_steps_of_an_episode(self, nesting: dict[str, Any]) -> None:
        player = Player(max_episode_steps=6, **nesting)
        for _ in range(3):
            for step in range(6):
                assert not player.truncated
                player.step()
                assert player.truncated == (step == 5)
            assert not player.terminated
            assert player.info["episode"]["l"][0] == player.frames
            player.step()
            assert player.lives == 5

    def test_of_steps_truncates_an_episode_that_also_terminates(self) -> None:
        player = Player(episodic_life=True)
        player.lose_life()
        steps = int(player.info["elapsed_step"][0])
        limited = Player(episodic_life=True, max_episode_steps=steps)
        limited.lose_life()
        assert (limited.terminated, limited.truncated) == (True, True)
        limited.step()
        assert limited.lives == 4
        limited.step()
        assert not limited.truncated  # the steps are counted anew

    def test_of_a_game_of_several_players(self) -> None:
        envs = make("pong", players=2, seeding="ale", max_num_frames_per_episode=61, noops=(3, 3))
        _, info = envs.reset(seed=1)
        begun = int(info["episode_frame_number"][0])
        while True:
            _, _, terminated, truncated, info = envs.step(np.zeros((1, 2), int))
            if truncated.any():
                break
        assert truncated.all()
        assert not terminated.any()
        assert info["episode_frame_number"][0] == 61
        *_, info = envs.step(np.zeros((1, 2), int))
        assert info["episode_frame_number"][0] == begun


class TestStates:
    def test_of_other_settings_leave_no_lost_life_behind(self) -> None:
        player = Player(episodic_life=True, seamless_lives=True)
        player.lose_life()
        other = Player(seamless_lives=True)
        (forged,) = other.envs.snapshot()
        other.envs.restore(None, [forged._replace(state=player.envs.snapshot()[0].state)])
        other.step()
        for _ in range(3):
            other.step()
            assert not other.terminated

    @pytest.mark.parametrize("fill", [b"\x00", b"\xff"])
    @pytest.mark.parametrize("seeding", ["gymnasium", "ale"])
    def test_that_are_damaged_are_played(self, seeding: str, fill: bytes) -> None:
        """The end of a state has the generator, numbers and flags. A generator of zeros would draw zeros for ever."""
        fields: dict[str, Any] = {"noops": (3, 11), "frameskip": (2, 7), "episodic_life": True, "fire": "before_noops"}
        player = Player(seeding=seeding, max_frames=100, max_episode_steps=9, **fields)
        (state,) = player.envs.snapshot()
        data, image = state.state.__getstate__()
        size = {"gymnasium": 40, "ale": 2500}[seeding] + 36
        damaged: Any = _emulator.MemberSnapshot.__new__(_emulator.MemberSnapshot)
        damaged.__setstate__((data[:-size] + fill * size, image))
        player.envs.restore(None, [state._replace(state=damaged)])
        for _ in range(40):
            player.step(1)
        player.reset()
        assert 3 <= player.frames <= 13

    def test_have_the_steps_of_the_episode(self) -> None:
        player = Player(max_episode_steps=6)
        for _ in range(4):
            player.step()
        (state,) = player.envs.snapshot()
        for _ in range(2):
            player.envs.restore(None, [state])
            player.step()
            assert not player.truncated
            player.step()
            assert player.truncated


def make_engine(fields: dict[str, Any]) -> _emulator.VectorEngine:
    """An engine with settings that `Task` may refuse."""
    episode = filled_by_name(_emulator.EpisodeSettings(), Task.of("pong").with_checked(**fields), acts_after_end=False)
    with mock.patch("atari.vector.options.episode_settings", return_value=episode):
        return atari.AtariVectorEnv("pong", 1, players=fields.get("players"))._options.make_engine()


class TestSettings:
    def test_are_filled_by_name(self) -> None:
        task = look_up("pong").task(None, {"frameskip": 3, "fire": "after_noops", "fire_unit": "skip"}, BASE)
        episode = filled_by_name(_emulator.EpisodeSettings(), task, acts_after_end=True)
        assert (episode.frameskip, episode.noops, episode.max_frames) == ((3, 4), (0, 0), None)
        assert (episode.fire, episode.fire_unit) == (_emulator.FirePress.AFTER_NOOPS, _emulator.Unit.SKIP)
        drawn = filled_by_name(_emulator.EpisodeSettings(), task.replace(frameskip=(2, 5)), acts_after_end=True)
        assert drawn.frameskip == (2, 5)
        pixels = _emulator.PixelFormat.RGB
        observation = filled_by_name(_emulator.ObservationSettings(), task, pixels=pixels)
        assert (observation.pixels, observation.padding) == (pixels, _emulator.Padding.RESET)

    def test_have_the_defaults_of_ale_pys_vector(self) -> None:
        task = Task.of("pong", preset="ale_vector", fire_again=False, seeding="ale")
        ale, default = episode_settings(task), _emulator.EpisodeSettings()
        for name in (name for name, lane in vars(type(ale)).items() if isinstance(lane, property)):
            assert getattr(default, name) == getattr(ale, name), name

    @pytest.mark.parametrize(
        ("kind", "missing"),
        [(_emulator.EpisodeSettings, "acts_after_end"), (_emulator.ObservationSettings, "pixels")],
    )
    def test_are_fields_of_a_task_or_given(self, kind: Any, missing: str) -> None:
        names = [name for name, lane in vars(kind).items() if isinstance(lane, property)]
        assert set(names) - set(FIELDS) == {missing}
        with pytest.raises(AttributeError, match=missing):
            filled_by_name(kind(), Task.of("pong"))

    @pytest.mark.parametrize(
        ("fields", "text"),
        [
            ({"fire": "before_noops", "fire_unit": "skip"}, "whole skips of FIRE follow the no-ops"),
            ({"seamless_lives": True, "lives_unit": "skip"}, "seamless lives are those of single frames"),
            ({"seamless_lives": True, "fire_unit": "skip"}, "seamless lives are those of single frames"),
            ({"max_episode_steps": 0}, "a limit is 1 or more; leave it out for none"),
            ({"noops": (3, 2)}, "noops must be within 0..1000000, the first not above the second"),
            ({"frameskip": (4, 4)}, "frameskip must be within 1..10000, the first below the second"),
        ],
    )
    def test_without_a_meaning_are_refused(self, fields: dict[str, Any], text: str) -> None:
        with pytest.raises(ValueError, match=text):
            make_engine(fields)

    @pytest.mark.parametrize("name", ["episodic_life", "life_loss_info", "fire_counts"])
    def test_of_one_player_are_refused_for_several(self, name: str) -> None:
        with pytest.raises(ValueError, match="FIRE and lost lives are settings of one player"):
            make_engine({"players": 2, "seeding": "ale", name: True})
