"""What each wrapper and preset refuses when it is made, and the words of the error."""

import re
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import AtariPreprocessing

import atari
from atari import AtariEnv, Task
from atari.wrappers import (
    ActionDelay,
    ClipReward,
    DqnPreprocessing,
    EpisodicLife,
    ExpressionReward,
    FireReset,
    FrameSkip,
    FrameStack,
    Grayscale,
    LifeLossInfo,
    NoopReset,
    ObservationDelay,
    RamObservation,
    Resize,
    StickyActions,
    preset,
    preset_options,
)
from atari.wrappers.layers import AleSeeding

Dqn, FRAMES = DqnPreprocessing, {"frameskip": 1, "repeat_action_probability": 0.0}


def pong(**options: Any) -> AtariEnv:
    return AtariEnv("pong", **{**FRAMES, **options})


ARGUMENTS: list[tuple[Any, dict[str, Any], type[Exception], str]] = [
    (ClipReward, {"min_reward": 1, "max_reward": 1}, ValueError, "min_reward must be less than max_reward"),
    (ClipReward, {"min_reward": 2, "max_reward": -2}, ValueError, "min_reward must be less than max_reward"),
    (ClipReward, {"min_reward": float("nan")}, ValueError, "min_reward must be less than max_reward"),
    (EpisodicLife, {"on_reset": "fire"}, ValueError, "one of 'noop', 'continue', 'new_game', got 'fire'"),
    (FrameSkip, {"frame_skip": 0}, ValueError, "frame_skip must be"),
    (FrameSkip, {"frame_skip": "4"}, TypeError, "frame_skip must be"),
    (FrameSkip, {"frame_skip": True}, TypeError, "frame_skip must be"),
    (FrameStack, {"stack_size": 0}, ValueError, "stack_size must be within 1"),
    (FrameStack, {"stack_size": 2.0}, TypeError, "stack_size must be an integer"),
    (FrameStack, {"padding_type": "first"}, ValueError, "padding_type must be one of 'reset', 'zero', got 'first'"),
    *((Grayscale, {"keep_dim": no}, TypeError, "keep_dim must be True or False") for no in (2**31, -1, 1, None, "no")),
    (Resize, {"shape": 84}, TypeError, "shape must be"),
    (Resize, {"shape": (84, 84, 3)}, TypeError, "shape must be"),
    (Resize, {"shape": (0, 84)}, ValueError, "shape must be"),
    (NoopReset, {"noop_max": -1}, ValueError, "noop_max must be within 0"),
    (NoopReset, {"noop_max": 2.5}, TypeError, "noop_max must be an integer"),
    (NoopReset, {"noop_max": 3, "noop_min": 4}, ValueError, "noop_min must be within 0..3, got 4"),
    (NoopReset, {"fire_again": False}, ValueError, "fire_again=False is about an inner FireReset, and there is none"),
    (StickyActions, {"repeat_action_probability": -0.1}, ValueError, "repeat_action_probability must be"),
    (StickyActions, {"repeat_action_probability": 1.5}, ValueError, "repeat_action_probability must be"),
    (StickyActions, {"repeat_action_probability": "x"}, TypeError, "repeat_action_probability must be"),
    (ExpressionReward, {"reward": None}, TypeError, "reward must be an expression"),
    (ExpressionReward, {"reward": "lives_lst"}, ValueError, "did you mean 'lives_lost'?"),
    (ActionDelay, {"delay": -1}, ValueError, "delay must be within 0..60, got -1"),
    (ActionDelay, {"delay": (5, 61)}, ValueError, "delay must be within 0..60, got 61"),
    (ActionDelay, {"delay": (5, 2)}, ValueError, "low of at most high"),
    (ActionDelay, {"delay": "5"}, TypeError, "a number such as 3, or (low, high)"),
    (ActionDelay, {"delay": 1.5}, TypeError, "delay must be an integer"),
    (ObservationDelay, {"delay": 61}, ValueError, "delay must be within 0..60, got 61"),
    (Dqn, {"frame_skip": 0}, ValueError, "frame_skip must be within 1"),
    (Dqn, {"frame_skip": (0, 3)}, ValueError, "frame_skip must be within 1"),
    (Dqn, {"frame_skip": (3, 3)}, ValueError, "low..high-1 frames and needs low < high, got (3, 3)"),
    (Dqn, {"frame_skip": (1, 2, 3)}, ValueError, "an integer or (low, high), got (1, 2, 3)"),
    (Dqn, {"frame_skip": 2.5}, TypeError, "frame_skip must be an integer"),
    (Dqn, {"obs_type": "rgb"}, ValueError, "obs_type must be one of 'image', 'ram', got 'rgb'"),
    (Dqn, {"obs_type": "ram", "grayscale": False}, ValueError, "grayscale=False is about images and has no effect"),
    (Dqn, {"obs_type": "ram", "stack_size": 0}, ValueError, "stack_size must be within 1"),
    (Dqn, {"obs_type": "ram", "screen_size": None}, ValueError, "screen_size=None is about images"),
    (Dqn, {"obs_type": "ram", "end_frames": "envpool"}, ValueError, "end_frames='envpool' is about images"),
    (Dqn, {"screen_size": 0}, ValueError, "screen_size must be within 1"),
    (Dqn, {"screen_size": (84, 84, 84)}, ValueError, "an integer or (width, height)"),
    (Dqn, {"screen_size": 84.5}, TypeError, "screen_size must be an integer"),
    (Dqn, {"stack_size": 0}, ValueError, "stack_size must be within 1"),
    (Dqn, {"max_frames": 0}, ValueError, "max_frames must be within 1"),
    (Dqn, {"padding_type": "first"}, ValueError, "padding_type must be one of 'reset', 'zero'"),
    (Dqn, {"pool_rgb": True, "end_frames": "envpool"}, ValueError, "'last' or 'baselines', got 'envpool'"),
    (Dqn, {"end_frames": "stale"}, ValueError, "'last', 'gymnasium', 'baselines', 'envpool', got 'stale'"),
]
"""A wrapper of Pong, its arguments, and the error."""

reward, late, early = (partial(kind, **{name: value}) for kind, name, value in (
    (ExpressionReward, "reward", "reward"), (ActionDelay, "delay", 1), (ObservationDelay, "delay", 1)
))  # fmt: skip
TWICE = "inside it already plays"
ENVIRONMENTS: list[tuple[Any, Any, str]] = [
    (FrameSkip, lambda: pong(obs_type="ram"), "FrameSkip(max_pool=True) works on pixels"),
    (Resize, lambda: pong(obs_type="ram"), "(128,), uint8); make the environment with obs_type='rgb' (not 'ram')"),
    (Grayscale, lambda: pong(obs_type="ram"), "Grayscale"),
    (Grayscale, lambda: pong(obs_type="grayscale"), "Grayscale"),
    (RamObservation, lambda: pong(obs_type="ram"), "are RAM already; make the environment with obs_type='rgb'"),
    (Dqn, lambda: pong(obs_type="ram"), "works on pixels"),
    (Dqn, lambda: pong(sound_obs=True), "sound_obs=False"),
    (partial(Dqn, obs_type="ram"), lambda: pong(sound_obs=True), "has no sound; make the environment with sound_obs"),
    (partial(Dqn, obs_type="ram"), lambda: pong(frameskip=4), f"AtariEnv {TWICE} 4 a step"),
    (Dqn, lambda: pong(frameskip=4), f"AtariEnv {TWICE} 4 a step"),
    (FrameSkip, lambda: pong(frameskip=4), f"AtariEnv {TWICE} 4 a step, so"),
    (FrameSkip, lambda: pong(frameskip=(2, 5)), f"AtariEnv {TWICE} (2, 5)"),
    (FrameSkip, lambda: gymnasium.make("ALE/Pong-v5"), f"AtariEnv {TWICE} 4"),
    (FrameSkip, lambda: FrameSkip(pong(), 2), f"FrameSkip {TWICE} 2"),
    (FrameSkip, lambda: Dqn(pong(), stack_size=None), f"DqnPreprocessing {TWICE} 4"),
    (FrameSkip, lambda: AtariPreprocessing(pong(), frame_skip=3), f"AtariPreprocessing {TWICE} 3"),
    (FrameSkip, lambda: gymnasium.wrappers.RepeatAction(pong(), 5), f"RepeatAction {TWICE} 5"),
    (FrameSkip, lambda: gymnasium.wrappers.MaxAndSkipObservation(pong(), 6), f"MaxAndSkipObservation {TWICE} 6"),
    (
        FrameSkip,
        lambda: gymnasium.wrappers.MaxAndSkipObservation(pong(), 6),
        "make the environment with frameskip=1 or from a NoFra",
    ),
    (FrameSkip, lambda: atari.make("pong", preset="dqn2015", stack_num=None), f"EpisodeEnv {TWICE} 4 a step"),
    (StickyActions, lambda: pong(repeat_action_probability=0.25), "of pong are sticky already (probability 0.25)"),
    (StickyActions, lambda: AtariEnv("backgammon", **FRAMES), "NOOP, which is no action of this game"),
    (LifeLossInfo, lambda: EpisodicLife(pong()), "an inner EpisodicLife ends the episodes that LifeLossInfo lets go"),
    (LifeLossInfo, lambda: preset(pong(), "baselines"), "an inner EpisodicLife"),
    (partial(NoopReset, fire_again=False), lambda: EpisodicLife(pong()), "about an inner FireReset, and there is none"),
    (partial(FireReset, then_action_2=True), lambda: pong(continuous=True), "at least three discrete actions"),
    (reward, lambda: ClipReward(pong()), "the `reward` of an expression is the game's, and ClipReward inside"),
    (reward, lambda: reward(pong()), "the game's, and ExpressionReward inside ExpressionReward changes it"),
    (late, lambda: late(pong()), "use one with the sum of both delays"),
    (early, lambda: early(pong()), "use one with the sum of both delays"),
    (late, lambda: atari.make("pong", preset="dqn2015"), "make the environment with action_delay=1"),
    (early, lambda: atari.make("pong", preset="dqn2015"), "make the environment with observation_delay=1"),
]
"""A wrapper, an environment that does not fit, and the text of the ValueError."""


@pytest.mark.parametrize(("wrapper", "arguments", "error", "text"), ARGUMENTS)
def test_arguments(wrapper: Any, arguments: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=re.escape(text)):
        wrapper(pong(), **arguments)


@pytest.mark.parametrize(("wrapper", "make", "text"), ENVIRONMENTS)
def test_environments(wrapper: Any, make: Any, text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        wrapper(make())


def test_environments_that_fit(scripted: Any) -> None:
    FrameSkip(FrameSkip(gymnasium.wrappers.StickyAction(pong(), 0.25), 1), 4)
    StickyActions(AtariEnv("backgammon", **FRAMES, full_action_space=True))
    NoopReset(FireReset(scripted(meanings=["NOOP", "UP"])), fire_again=False).reset()
    with pytest.raises(ValueError, match="at least three discrete actions"):
        FireReset(scripted(meanings=["NOOP", "FIRE"]), then_action_2=True)
    with pytest.raises(TypeError, match="put it inside other wrappers"):
        FrameStack(RamObservation(pong()))


OURS = (AleSeeding, Dqn, LifeLossInfo, RamObservation, reward, late, early, lambda env: preset(env, "gymnasium"))


@pytest.mark.parametrize("wrapper", OURS)
def test_environments_of_others(wrapper: Any, scripted: Any) -> None:
    with pytest.raises(TypeError, match=r"reads the emulator of an atari\.AtariEnv.*make one with atari\.make"):
        wrapper(scripted())


@pytest.mark.parametrize("wrapper", [Grayscale, Resize])
@pytest.mark.parametrize(
    ("image", "error"),
    [(3, TypeError), (np.zeros((210, 160, 3)), TypeError), (np.zeros((160, 210, 3), np.uint8), ValueError)],
)
def test_another_image(wrapper: Any, image: Any, error: type[Exception]) -> None:
    with pytest.raises(error, match=rf"^{wrapper.__name__} takes images .* got"):
        wrapper(pong()).observation(image)


FIELDS: dict[str, Any] = {
    **{"action_delay": 3, "observation_delay": 3, "reward": "lives", "noops": (1, 30), "stack_num": 4},
    **{"reward_clipping": True, "max_episode_steps": 9},
}


@pytest.mark.parametrize("field", FIELDS)
def test_a_field_of_wrappers_is_none_of_an_environment(field: str) -> None:
    with pytest.raises(ValueError, match=rf"{field}=.* needs them; use atari\.make"):
        AtariEnv("pong", **{field: FIELDS[field]})
    if field != "max_episode_steps":
        with pytest.raises(ValueError, match=rf"sound_obs=True is for an AtariEnv without wrappers, and {field}="):
            Task("pong", **{field: FIELDS[field]}, sound_obs=True)


@pytest.mark.parametrize("arguments", [one[1:] for one in ARGUMENTS if one[0] is ActionDelay])
def test_the_field_refuses_what_the_wrapper_refuses(arguments: Any) -> None:
    options, error, text = arguments
    with pytest.raises(error, match=re.escape(text.replace("delay must", "action_delay must"))):
        Task("pong", action_delay=options["delay"])


@pytest.mark.parametrize(
    ("name", "options", "text"),
    [
        ("baselines", {"frameskip": 4}, "needs an environment made with frameskip=1, and this one has 4; make it with"),
        ("gymnasium", {"frameskip": (2, 5)}, "frameskip=1, and this one has (2, 5)"),
        ("dqn2015", {"repeat_action_probability": 0.25}, "repeat_action_probability=0.0, and this one has 0.25"),
        ("dqn2015", {"full_action_space": True}, "full_action_space=False, and this one has True"),
        ("machado2018", {"repeat_action_probability": 0.25}, "full_action_space=True, and this one has False; make it "
         "with atari.AtariEnv('pong', frameskip=1, repeat_action_probability=0.25, full_action_space=True, max_num_"),
        ("dopamine", {}, "repeat_action_probability=0.25, and this one has 0.0"),
        ("atari100k", {"repeat_action_probability": 0.1}, "repeat_action_probability=0.0, and this one has 0.1"),
    ],
)  # fmt: skip
def test_an_environment_that_does_not_fit_a_preset(name: str, options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        preset(pong(**options), name)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("baseline", "there is no preset 'baseline'; did you mean 'baselines'?"),
        *(("Dopamine", "'dopamine'"), ("nature", "'dqn2015'"), ("cleanrl", "'baselines'"), ("sb3_zoo", "'baselines'")),
        ("machado", "did you mean 'machado2018'?"),
        ("???", f"see the list ({', '.join(atari.PRESETS)})"),
        (None, "there is no preset None"),
    ],
)
def test_an_unknown_preset(name: Any, text: str) -> None:
    for make in (lambda: preset(pong(), name), lambda: preset_options(name)):
        with pytest.raises(ValueError, match=re.escape(text)):
            make()


DAMAGED: list[tuple[Any, str, Any]] = [
    (partial(ActionDelay, delay=3), "delay", 4),
    (partial(ActionDelay, delay=3), "moves", np.full((3, 2), 18, np.float32)),
    (partial(ObservationDelay, delay=3), "delay", 4),
    (partial(ExpressionReward, reward="reward"), "inputs", np.array([np.nan])),
    (StickyActions, "action", 6),
]


@pytest.mark.parametrize(("wrapper", "name", "value"), DAMAGED)
def test_a_damaged_state(wrapper: Any, name: str, value: Any) -> None:
    env = wrapper(pong())
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the snapshot is damaged: "):
        env._load_state({**env._save_state(), name: value})


@pytest.mark.parametrize("kind", [ActionDelay, ObservationDelay])
def test_a_step_that_is_refused_leaves_the_driver_as_it_was(kind: Any) -> None:
    env: Any = kind(pong(), 3)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(0)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action 6 is not within"):
        env.step(6)
    driver = env.unwrapped.driver
    assert (driver.convert, driver.delayed, driver.observers) == (None, None, [])


def test_wrong_numbers_of_noops_are_refused_before_the_reset(scripted: Any) -> None:
    env = NoopReset(scripted())
    for noops, error in ((-1, ValueError), ("3", TypeError)):
        with pytest.raises(error, match="noops must be"):
            env.reset(options={"noops": noops})
    assert env.unwrapped.resets == []
