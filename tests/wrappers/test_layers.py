"""The wrappers of a task: how they are nested, their arguments, and the frames that a reset of each nesting plays."""

import itertools
from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from tasks import task

from atari import AtariEnv
from atari.wrappers.layers import layers_of, wrap


def names(**fields: Any) -> str:
    return " ".join(wrapper.__name__ for wrapper, _ in layers_of(task(**fields)))


def arguments(wrapper: str, **fields: Any) -> dict[str, Any]:
    """The arguments of the wrapper of this name."""
    (found,) = (arguments for layer, arguments in layers_of(task(**fields)) if layer.__name__ == wrapper)
    return dict(found)


LETTERS = {"L": "EpisodicLife", "N": "NoopReset", "F": "FireReset", "S": "DqnPreprocessing", "K": "FrameStack"}


@pytest.mark.parametrize(
    ("fire_unit", "lives_unit", "fire", "nesting"),
    [
        ("frame", "frame", "after_noops", "LNFS"),
        ("frame", "frame", "before_noops", "LFNS"),
        ("frame", "skip", "after_noops", "NFSLK"),
        ("frame", "skip", "before_noops", "FNSLK"),
        ("skip", "frame", "after_noops", "LNSFK"),
        ("skip", "skip", "after_noops", "NSLFK"),
    ],
)
class TestNesting:
    def test_of_all_layers(self, fire_unit: str, lives_unit: str, fire: str, nesting: str) -> None:
        units = {"fire_unit": fire_unit, "lives_unit": lives_unit, "fire": fire}
        expected = [LETTERS[letter] for letter in nesting]
        assert names(**units, noops=(1, 30), episodic_life=True) == " ".join([*expected, "GameStatistics"])

    def test_of_some_layers(self, fire_unit: str, lives_unit: str, fire: str, nesting: str) -> None:
        """A layer that a task does not need is left out, and the stack is made by the skip if nothing is outside."""
        for lives, noops, fires in itertools.product([False, True], repeat=3):
            fields = {"episodic_life": lives, "noops": (0, 3 * noops), "fire": fire if fires else "never"}
            left_out = "L" * (not lives) + "N" * (not noops) + "F" * (not fires)
            letters = "".join(letter for letter in nesting if letter not in left_out).removesuffix("K")
            stacked = not letters.endswith("S")
            expected = [*(LETTERS[letter] for letter in letters), *["FrameStack"] * stacked, "GameStatistics"]
            units = {"fire_unit": fire_unit, "lives_unit": lives_unit}
            assert names(**units, **fields) == " ".join(expected)
            assert arguments("DqnPreprocessing", **units, **fields)["stack_size"] == (None if stacked else 4)


ALE_SEED = {"seeding": "ale"}
FIRE_OUTSIDE: dict[str, Any] = {"fire": "after_noops", "fire_unit": "skip"}


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        (ALE_SEED, "AleSeeding NoopReset DqnPreprocessing GameStatistics"),
        ({**ALE_SEED, "episodic_life": True}, "AleSeeding EpisodicLife NoopReset DqnPreprocessing GameStatistics"),
        ({"max_episode_steps": 9}, "DqnPreprocessing StepLimit GameStatistics"),
        ({"reward_clipping": True}, "DqnPreprocessing GameStatistics ClipReward"),
        ({"reward": "lives"}, "DqnPreprocessing GameStatistics ExpressionReward"),
        ({"reward": "1", "reward_clipping": True}, "DqnPreprocessing GameStatistics ExpressionReward ClipReward"),
        (
            {"life_loss_info": True, "max_episode_steps": 9, "reward_clipping": True, "obs_type": "rgb_dict"},
            "DqnPreprocessing RamObservation LifeLossInfo StepLimit GameStatistics ClipReward",
        ),
        (
            {**FIRE_OUTSIDE, "obs_type": "dict", "life_loss_info": True},
            "DqnPreprocessing FireReset FrameStack RamObservation LifeLossInfo GameStatistics",
        ),
        ({**FIRE_OUTSIDE, "obs_type": "ram"}, "DqnPreprocessing FireReset FrameStack GameStatistics"),
        ({**FIRE_OUTSIDE, "stack_num": None}, "DqnPreprocessing FireReset GameStatistics"),
    ],
)
def test_other_layers(fields: dict[str, Any], expected: str) -> None:
    assert names(**fields) == expected


def test_an_environment_that_skips_frames_is_refused() -> None:
    with pytest.raises(ValueError, match="already plays 4 a step"):
        wrap(AtariEnv("pong"), task())


def test_arguments() -> None:
    lives = {"episodic_life": True, "on_reset": "continue", "last_life": True}
    assert arguments("EpisodicLife", **lives) == {"on_reset": "continue", "last_life": True}
    assert arguments("LifeLossInfo", life_loss_info=True, last_life=True) == {"last_life": True}
    assert arguments("FireReset", fire="after_noops", third_action=True) == {"then_action_2": True}
    noops = {"noop_max": 7, "noop_min": 2, "fire_counts": False}
    assert arguments("NoopReset", noops=(2, 7)) == noops
    for fire, again in (("before_noops", False), ("before_noops", True), ("after_noops", True)):
        kept = {"fire_again": again} if fire == "before_noops" else {}
        fields = {"noops": (2, 7), "fire": fire, "fire_counts": True, "fire_again": again}
        assert arguments("NoopReset", **fields) == {**noops, "fire_counts": True, **kept}
    assert arguments("StepLimit", max_episode_steps=9) == {"max_episode_steps": 9}
    size: dict[str, Any] = {"img_height": 60, "img_width": 80, "stack_num": 3}
    shown = {**size, "obs_type": "rgb", "maxpool": False, "padding": "reset", "end_frames": "envpool"}
    played = {"frameskip": (2, 5), "episodic_life": True, "seamless_lives": True, "max_frames": 99}
    skip = {"frame_skip": (2, 5), "seamless_lives": True, "max_frames": 99, "stack_size": 3, "padding_type": "reset"}
    switches = {"grayscale": False, "max_pool": False, "pool_rgb": False}
    image = {**switches, "screen_size": (80, 60), "end_frames": "envpool"}
    assert arguments("DqnPreprocessing", **shown, **played) == {**skip, **image}
    assert arguments("DqnPreprocessing", **{**shown, **played, "obs_type": "ram"}) == {**skip, "obs_type": "ram"}
    assert arguments("FrameStack", **shown, **FIRE_OUTSIDE) == {"stack_size": 3, "padding_type": "reset"}
    assert arguments("DqnPreprocessing", pool_rgb=True)["pool_rgb"]


def made(game: str = "breakout", options: dict[str, Any] | None = None, **fields: Any) -> Any:
    env = AtariEnv(game, **{"frameskip": 1, "repeat_action_probability": 0.0, **(options or {})})
    return wrap(env, task(**fields), nested=True)


GRAY = spaces.Box(0, 255, (4, 84, 84), np.uint8)
RAM = spaces.Box(0, 255, (128,), np.uint8)


@pytest.mark.parametrize("unit", ["frame", "skip"])
@pytest.mark.parametrize(
    ("fields", "space"),
    [
        ({}, GRAY),
        ({"stack_num": None}, spaces.Box(0, 255, (84, 84), np.uint8)),
        ({"stack_num": 1, "img_height": None, "img_width": None}, spaces.Box(0, 255, (1, 210, 160), np.uint8)),
        ({"obs_type": "rgb", "stack_num": None}, spaces.Box(0, 255, (84, 84, 3), np.uint8)),
        ({"obs_type": "rgb", "img_height": 60}, spaces.Box(0, 255, (4, 60, 84, 3), np.uint8)),
        ({"obs_type": "ram"}, spaces.Box(0, 255, (4, 128), np.uint8)),
        ({"obs_type": "ram", "stack_num": None}, RAM),
        ({"obs_type": "dict"}, spaces.Dict({"image": GRAY, "ram": RAM})),
        ({"obs_type": "rgb_dict", "stack_num": 2}, spaces.Dict({"image": spaces.Box(0, 255, (2, 84, 84, 3), np.uint8), "ram": RAM})),
    ],
)  # fmt: skip
def test_observations(unit: str, fields: dict[str, Any], space: spaces.Space[Any]) -> None:
    env = made(fire="after_noops", fire_unit=unit, **fields)
    assert env.observation_space == space
    for begins in (True, False):
        observation = env.reset(seed=0)[0] if begins else env.step(2)[0]
        assert observation in space
        if isinstance(observation, dict):
            np.testing.assert_array_equal(observation["ram"], env.unwrapped.core.ram())


def lose_a_life(env: Any) -> int:
    """The frame number after the step that lost the first life; the ball falls if the paddle stays at the right."""
    for step in range(200):
        *_, terminated, truncated, info = env.step(1 if step == 0 else 2)
        assert not truncated
        if terminated:
            assert info["lives"] == 4
            return int(info["episode_frame_number"])
    raise AssertionError("no life was lost")


class TestFramesOfAReset:
    """Breakout, which has FIRE, with 5 no-ops."""

    @pytest.mark.parametrize(
        ("fields", "frames"),
        [
            ({}, 5),
            ({"fire": "after_noops"}, 5 + 1),
            ({"fire": "before_noops"}, 1 + 5),
            ({"fire": "after_noops", "fire_counts": True}, 4 + 1),
            ({"fire": "after_noops", "third_action": True}, 5 + 2),
            (FIRE_OUTSIDE, 5 + 4),
            ({**FIRE_OUTSIDE, "third_action": True}, 5 + 8),
            ({**FIRE_OUTSIDE, "frameskip": 3}, 5 + 3),
            ({**FIRE_OUTSIDE, "frameskip": 3, "third_action": True}, 5 + 6),
        ],
    )
    def test_of_a_new_game(self, fields: dict[str, Any], frames: int) -> None:
        env = made(noops=(5, 5), **fields)
        for seed in (0, None):
            assert env.reset(seed=seed)[1]["episode_frame_number"] == frames

    @pytest.mark.parametrize(
        ("fields", "frames"),
        [
            # L N F S: a frame of NOOP, the no-ops, a frame of FIRE.
            ({"fire": "after_noops", "on_reset": "noop"}, 1 + 5 + 1),
            ({"fire": "after_noops", "on_reset": "continue"}, 5 + 1),
            # L F N S
            ({"fire": "before_noops", "on_reset": "noop"}, 1 + 1 + 5),
            ({"fire": "before_noops", "on_reset": "continue", "third_action": True}, 2 + 5),
            # N F S L: only the layers outside of L act, so that no no-ops and no FIRE are played.
            ({"fire": "after_noops", "lives_unit": "skip", "on_reset": "noop"}, 4),
            ({"fire": "before_noops", "lives_unit": "skip", "on_reset": "noop", "frameskip": 3}, 3),
            ({"fire": "after_noops", "lives_unit": "skip", "on_reset": "continue"}, 0),
            # L N S F: a frame of NOOP, the no-ops, skips of FIRE and of the third action.
            ({**FIRE_OUTSIDE, "on_reset": "noop", "third_action": True}, 1 + 5 + 4 + 4),
            ({**FIRE_OUTSIDE, "on_reset": "continue"}, 5 + 4),
            # N S L F: a skip of NOOP, then FIRE.
            ({**FIRE_OUTSIDE, "lives_unit": "skip", "on_reset": "noop"}, 4 + 4),
            ({**FIRE_OUTSIDE, "lives_unit": "skip", "on_reset": "continue"}, 4),
        ],
    )
    def test_after_a_lost_life(self, fields: dict[str, Any], frames: int) -> None:
        env = made(noops=(5, 5), episodic_life=True, **fields)
        env.reset(seed=0)
        before = lose_a_life(env)
        _, info = env.reset()
        assert (info["episode_frame_number"] - before, info["lives"]) == (frames, 4)
        env.step(2)
        _, info = env.reset(options={"new_game": True})
        assert info["lives"] == 5
        assert info["episode_frame_number"] < before

    def test_lives_of_frames_cut_a_skip_and_lives_of_skips_do_not(self) -> None:
        frames = []
        for unit in ("frame", "skip"):
            env = made(episodic_life=True, lives_unit=unit, on_reset="continue")
            env.reset(seed=0)
            frames.append(lose_a_life(env))
        assert frames[0] % 4 != 0
        assert frames[1] == frames[0] + -frames[0] % 4


class TestFireAgain:
    """With a limit of the emulator of 5 frames, which ends games in their no-ops."""

    @pytest.mark.parametrize(
        ("fields", "frames"),
        # FIRE and 4 no-ops, twice, then FIRE and 2; or FIRE and 4, then 5, then 1.
        [({}, 3), ({"fire_again": False}, 1), ({"fire_again": False, "lives_unit": "skip", "episodic_life": True}, 1)],
    )
    def test_frames(self, fields: dict[str, Any], frames: int) -> None:
        env = made(noops=(10, 10), fire="before_noops", options={"max_num_frames_per_episode": 5}, **fields)
        assert env.reset(seed=0)[1]["episode_frame_number"] == frames

    def test_neither_is_the_third_action_played_again(self) -> None:
        fields = {"noops": (10, 10), "fire": "before_noops", "third_action": True, "fire_again": False}
        env = made(options={"max_num_frames_per_episode": 5}, **fields)
        assert env.reset(seed=0)[1]["episode_frame_number"] == 10 - 3 - 5


class TestMaxFrames:
    def test_counts_skips_of_fire(self) -> None:
        for unit, steps in (("frame", 3), ("skip", 2)):
            env = made(noops=(5, 5), fire="after_noops", fire_unit=unit, max_frames=12)
            for _ in range(2):
                env.reset(seed=0)
                assert [env.step(2)[3] for _ in range(steps)] == [False] * (steps - 1) + [True]

    def test_counts_skips_of_a_noop(self) -> None:
        """The game of 1000 frames and 5 no-ops goes on over lost lives, and then a new one begins."""
        env = made(noops=(5, 5), episodic_life=True, lives_unit="skip", on_reset="noop", max_frames=1000)
        env.reset(seed=0)
        lose_a_life(env)
        env.reset()
        truncated = False
        while not truncated:
            *_, terminated, truncated, info = env.step(0)
            assert not terminated
        assert info["lives"] == 4
        assert info["episode_frame_number"] == 1005
        assert env.reset()[1]["lives"] == 5

    def test_that_fire_exceeds_begins_games_as_often(self) -> None:
        """Each skip of FIRE ends after 3 frames, and the game after it is the one that is played."""
        env = made(**FIRE_OUTSIDE, max_frames=3)
        _, info = env.reset(seed=0)
        assert info["episode_frame_number"] == 0
        assert env.step(2)[3]


class TestStack:
    @pytest.mark.parametrize("padding", ["zero", "reset"])
    @pytest.mark.parametrize("fields", [{"fire": "after_noops", "fire_unit": "skip"}, {"lives_unit": "skip"}, {}])
    def test_a_reset_fills_it_anew_with_the_last_image(self, fields: dict[str, Any], padding: str) -> None:
        env = made(episodic_life=True, on_reset="continue", padding=padding, **fields)
        single = made(episodic_life=True, on_reset="continue", stack_num=None, **fields)
        for each in (env, single):
            each.reset(seed=0)
            lose_a_life(each)
        stack, image = env.reset()[0], single.reset()[0]
        np.testing.assert_array_equal(stack[-1], image)
        np.testing.assert_array_equal(stack[:-1], [image if padding == "reset" else 0 * image] * 3)


class TestMaxEpisodeSteps:
    def test_truncates_and_ends_the_statistics_of_the_game(self) -> None:
        env = made(max_episode_steps=7, noops=(5, 5))
        for _ in range(2):
            env.reset(seed=0)
            for step in range(1, 8):
                *_, terminated, truncated, info = env.step(2)
                assert (terminated, truncated) == (False, step == 7)
                assert ("episode" in info) == (step == 7)
            assert (info["episode"]["l"], info["episode"]["r"]) == (5 + 28, 0.0)
            assert info["elapsed_step"] == 7
            assert not info["terminated"]

    def test_counts_the_steps_of_an_episode_not_of_a_game(self) -> None:
        env = made(max_episode_steps=60, episodic_life=True, on_reset="continue", fire="after_noops")
        env.reset(seed=0)
        lose_a_life(env)
        _, info = env.reset()
        elapsed = info["elapsed_step"]
        assert elapsed > 0
        truncated = False
        steps = 0
        while not truncated and steps < 100:
            *_, terminated, truncated, info = env.step(0)
            steps += 1
            if terminated and not truncated:
                env.reset()
                steps = 0
        assert (steps, truncated) == (60, True)
        assert info["episode"]["l"] == info["episode_frame_number"]

    def test_of_a_lost_life_is_both(self) -> None:
        def steps_of_a_life(limit: int | None) -> tuple[int, bool, bool, bool]:
            env = made(max_episode_steps=limit, episodic_life=True, on_reset="continue", fire="after_noops")
            env.reset(seed=0)
            for step in itertools.count(1):
                *_, terminated, truncated, info = env.step(2)
                if terminated or truncated:
                    return step, terminated, truncated, "episode" in info
            raise AssertionError

        steps, *flags = steps_of_a_life(None)
        assert flags == [True, False, False]
        assert steps_of_a_life(steps) == (steps, True, True, True)
        assert steps_of_a_life(steps - 1) == (steps - 1, False, True, True)


def test_life_loss_info_reports_and_goes_on() -> None:
    env = made(life_loss_info=True, fire="after_noops", reward_clipping=True)
    env.reset(seed=0)
    losses = 0
    for step in range(400):
        *_, terminated, truncated, info = env.step(1 if step % 9 == 0 else 2)
        assert not truncated
        losses += terminated
        if info["terminated"]:
            break
        assert "episode" not in info
    assert losses == 5
    assert info["episode"]["l"] == info["episode_frame_number"]


def test_a_reset_with_a_seed_begins_a_new_game_in_every_nesting() -> None:
    for fire_unit, lives_unit in itertools.product(("frame", "skip"), repeat=2):
        units = {"fire_unit": fire_unit, "lives_unit": lives_unit}
        env = made(fire="after_noops", episodic_life=True, on_reset="noop", **units)
        first = env.reset(seed=3)
        lose_a_life(env)
        again = env.reset(seed=3)
        np.testing.assert_array_equal(again[0], first[0])
        assert again[1]["frame_number"] == first[1]["frame_number"]


def test_an_end_in_a_skip_of_fire_begins_again_and_the_third_action_follows() -> None:
    """The emulator's limit of 6 frames: 5 no-ops and a frame of FIRE; again 5 no-ops, and a frame of the third action."""
    env = made(noops=(5, 5), **FIRE_OUTSIDE, third_action=True, options={"max_num_frames_per_episode": 6})
    _, info = env.reset(seed=0)
    assert info["episode_frame_number"] == 5
    assert env.step(2)[3]
