"""Snapshots of wrapped environments: what they contain, what they refuse, and the warning of a restore beneath."""

import copy
import inspect
import warnings
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit, TransformReward
from tasks import ALE, task

import atari
from atari import AtariEnv, wrappers
from atari.cores import snapshot
from atari.recording import RecordReplay, RecordVideo
from atari.wrappers.layers import StepLimit, wrap

PRESETS = sorted(atari.PRESETS)


def played(env: Any, steps: int, seed: int = 0) -> list[Any]:
    """All results of random actions, with a reset after each episode."""
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(int(rng.integers(env.action_space.n)))
        results.append((np.asarray(observation).tobytes(), reward, terminated, truncated, timeless(info)))
        if terminated or truncated:
            observation, info = env.reset()
            results.append((np.asarray(observation).tobytes(), timeless(info)))
    return results


def timeless(info: dict[str, Any]) -> dict[str, Any]:
    """The info without the seconds that an episode took."""
    episode = {name: value for name, value in info.get("episode", {}).items() if name != "t"}
    return {**info, "episode": episode}


def started(name: str = "baselines", game: str = "breakout", **options: Any) -> Any:
    env = atari.make(game, preset=name, **options)
    env.reset(seed=0)
    return env


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("steps", [0, 7, 150])
def test_a_preset_continues_over_lost_lives_and_new_games(name: str, steps: int) -> None:
    env, other = started(name), atari.make("breakout", preset=name)
    played(env, steps, seed=1)
    saved = env.snapshot()
    expected = played(env, 300)
    assert any(len(result) == 2 for result in expected)
    for restored in (env, other):
        restored.restore(saved)
        assert played(restored, 300) == expected


def test_every_wrapper_has_snapshots() -> None:
    classes = [value for value in vars(wrappers).values() if inspect.isclass(value)]
    missing = [c.__name__ for c in classes if issubclass(c, gymnasium.Wrapper) and not hasattr(c, "snapshot")]
    assert not missing
    for name in PRESETS:
        layer = atari.make("pong", preset=name)
        while type(layer).__module__.startswith("atari."):
            assert isinstance(layer, AtariEnv) or callable(layer.snapshot)
            if layer is layer.unwrapped:
                break
            layer = layer.env


OUTSIDE: dict[str, Any] = {"fire": "after_noops", "fire_unit": "skip", "episodic_life": True}

STACKS: dict[str, Any] = {
    "delayed actions": lambda env: wrappers.ActionDelay(wrappers.DqnPreprocessing(env), (3, 9)),
    "delayed frames": lambda env: wrappers.ObservationDelay(wrappers.DqnPreprocessing(env), (3, 9)),
    "lazy": lambda env: wrappers.FrameStack(wrappers.Grayscale(env), lazy=True),
    "rendered": lambda env: wrappers.preset(env, "dqn2015"),
    "lives that continue": lambda env: wrappers.NoopReset(wrappers.EpisodicLife(env, "continue")),
    "sticky outside": lambda env: wrappers.StickyActions(wrappers.FrameSkip(env)),
    "ALE": lambda env: wrap(env, task(**ALE, frameskip=(2, 5), max_episode_steps=25)),
    "FIRE and lives outside": lambda env: wrap(
        env, task(**OUTSIDE, third_action=True, lives_unit="skip", on_reset="noop", padding="reset")
    ),
    "FIRE outside": lambda env: wrap(env, task(**OUTSIDE, on_reset="continue", noops=(1, 6), max_frames=200)),
    "lives outside": lambda env: wrap(
        env, task(fire="before_noops", noops=(1, 6), episodic_life=True, lives_unit="skip", on_reset="continue")
    ),
    "Gymnasium's": lambda env: wrappers.ClipReward(TimeLimit(wrappers.FrameStack(env), 25)),
    "Gymnasium's without a state": lambda env: wrappers.FrameStack(TransformReward(env, lambda reward: 2 * reward)),
}


@pytest.mark.parametrize("name", STACKS)
def test_other_stacks(name: str) -> None:
    rendering = {"render_mode": "rgb_array_list"} if name == "rendered" else {}  # each frame through `step`
    env, other = (
        STACKS[name](gymnasium.make("BreakoutNoFrameskip-v4", disable_env_checker=True, **rendering)) for _ in range(2)
    )
    env.reset(seed=0)
    played(env, 40)
    saved = env.snapshot()
    expected = played(env, 400, seed=1)
    for restored in (env, other):
        restored.restore(saved)
        assert played(restored, 400, seed=1) == expected


def test_the_last_observation_of_a_lost_life_is_part_of_it() -> None:
    make = partial(gymnasium.make, "BreakoutNoFrameskip-v4", disable_env_checker=True)
    env, other = (wrappers.EpisodicLife(make(), "continue") for _ in range(2))
    env.reset(seed=0)
    ended = False
    while not ended:
        last, _, ended, _, _ = env.step(1)
    other.restore(env.snapshot())
    assert np.array_equal(other.reset()[0], last)


def test_continuous_sticky_actions() -> None:
    def make() -> Any:
        return wrappers.StickyActions(AtariEnv("breakout", repeat_action_probability=0.0, continuous=True), 0.9)

    env, other = make(), make()
    env.reset(seed=0)
    actions = [env.action_space.sample() for _ in range(60)]
    for action in actions[:20]:
        env.step(action)
    other.restore(env.snapshot())
    for action in actions[20:]:
        assert np.array_equal(env.step(action)[0], other.step(action)[0])


def test_wrappers_without_a_state_may_differ() -> None:
    """For example, a position of training is continued with the game's rewards."""
    training, evaluation = started(), AtariEnv("breakout", **wrappers.preset_options("baselines"))
    played(training, 30)
    env = wrappers.RamObservation(wrappers.preset(evaluation, "baselines", clip_reward=False))
    env.restore(training.snapshot())
    assert np.array_equal(env.step(0)[0]["image"], training.step(0)[0])


def test_recorders_are_in_the_way_of_nothing(tmp_path: Any) -> None:
    env = RecordVideo(started("machado2018"), tmp_path / "videos", sound=False)
    recorded = RecordReplay(env, tmp_path / "a.a26r")
    saved = recorded.snapshot()
    expected = played(recorded, 20)
    recorded.restore(saved)
    assert played(recorded, 20) == expected
    recorded.stop()
    started("machado2018").restore(saved)
    env.close()


@pytest.mark.parametrize("name", ["baselines", "machado2018"])
@pytest.mark.parametrize("cloned", [False, True])
def test_a_restore_beneath_warns_once_at_the_next_step(name: str, cloned: bool) -> None:
    env = started(name)
    core = env.unwrapped
    saved = core.clone_state() if cloned else core.snapshot()
    played(env, 20)
    (core.restore_state if cloned else core.restore)(saved)
    with pytest.warns(UserWarning, match="restored without its wrappers, whose frames, lives and counters"):
        env.step(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.step(0)
        (core.restore_state if cloned else core.restore)(saved)
        env.reset()
        env.step(0)


@pytest.mark.parametrize(
    "wrapper",
    [
        *(wrappers.FrameStack, wrappers.EpisodicLife, wrappers.StickyActions, wrappers.DqnPreprocessing),
        partial(wrappers.ExpressionReward, reward="reward"),
        partial(wrappers.ActionDelay, delay=2),
        partial(wrappers.ObservationDelay, delay=2),
    ],
)
def test_each_wrapper_with_a_state_warns(wrapper: Any) -> None:
    env = wrapper(AtariEnv("breakout", frameskip=1, repeat_action_probability=0.0))
    env.reset(seed=0)
    env.unwrapped.restore(env.unwrapped.snapshot())
    with pytest.warns(UserWarning, match=f"the AtariEnv in {type(env).__name__} was restored"):
        env.step(0)


@pytest.mark.filterwarnings("error")
def test_a_restore_of_the_stack_does_not_warn() -> None:
    env = started()
    env.restore(env.snapshot())
    env.step(0)
    wrappers.Resize(AtariEnv("pong")).unwrapped.restore(AtariEnv("pong").snapshot())


def test_a_wrapper_whose_state_is_unknown_is_named() -> None:
    class Own(gymnasium.Wrapper):
        pass

    for wrapper in (RecordEpisodeStatistics, Own):
        env = wrappers.FrameStack(wrapper(AtariEnv("pong")))
        with pytest.raises(TypeError, match=f"the state of the wrapper {wrapper.__name__} cannot be saved; put it"):
            env.snapshot()
        with pytest.raises(TypeError, match=f"the state of the wrapper {wrapper.__name__} cannot be saved"):
            env.restore(wrappers.FrameStack(AtariEnv("pong")).snapshot())


def test_other_environments_have_none(scripted: Any) -> None:
    with pytest.raises(TypeError, match=r"need an atari\.AtariEnv in the wrappers"):
        wrappers.FrameStack(scripted()).snapshot()


@pytest.mark.parametrize(
    ("other", "text"),
    [
        (
            lambda: started("dopamine", repeat_action_probability=0.25),
            r"0\.25, but this .* 0\.0; noops = \(0, 0\), not \(1, 30\); fire",
        ),
        (lambda: wrappers.StickyActions(started()), "taken with the wrappers StickyActions, "),
        (lambda: started(game="pong"), "taken with game = 'pong'"),
        (lambda: started(mode=4), "taken with mode = 4"),
        (lambda: started().unwrapped, "is of the AtariEnv without its wrappers; pass it to env.unwrapped.restore"),
    ],
)
def test_a_snapshot_of_another_stack_is_refused(other: Any, text: str) -> None:
    env = started()
    before = env.snapshot()
    with pytest.raises(ValueError, match=text):
        env.restore(other().snapshot())
    assert env.snapshot() == before


def test_other_arguments_are_refused() -> None:
    env, other = (StepLimit(AtariEnv("pong"), steps) for steps in (5, 6))
    with pytest.raises(ValueError, match="taken with other arguments of StepLimit"):
        env.restore(other.snapshot())
    small, large = (wrappers.DqnPreprocessing(AtariEnv("pong", frameskip=1), screen_size=size) for size in (42, 84))
    with pytest.raises(ValueError, match=r"taken with other arguments of DqnPreprocessing than {'frame_skip': 4"):
        large.restore(small.snapshot())


def test_a_snapshot_without_an_array_is_refused() -> None:
    env = started()
    facts, blobs = snapshot.unpack(env.snapshot())
    old = {name: blob for name, blob in blobs.items() if not name.endswith(".episode")}
    with pytest.raises(ValueError, match="has no episode of EpisodeEnv: it is damaged, or of another release"):
        env.restore(snapshot.pack(facts, old))


def test_a_snapshot_of_a_stack_is_none_of_an_environment() -> None:
    env = started()
    with pytest.raises(ValueError, match="with its wrappers; pass it to restore of the outermost wrapper"):
        env.unwrapped.restore(env.snapshot())


def forged(facts: dict[str, Any], blobs: dict[str, bytes]) -> list[bytes]:
    """Snapshots with a right checksum and a wrong content each."""
    wrong: list[Any] = [None, "x", 1.5, -(10**30), True, [], {}, [[]]]
    made = [snapshot.pack({**facts, "layers": value}, blobs) for value in (*wrong, [{}], [{"state": {}}], [None] * 3)]
    for number, layer in enumerate(facts["layers"]):
        for key in ("wrapper", "arguments", "state"):
            changed = [{**other} for other in facts["layers"]]
            changed[number][key] = None
            made.append(snapshot.pack({**facts, "layers": changed}, blobs))
        for name, now in layer["state"].items():
            for value in wrong:
                if type(value) is type(now):
                    continue
                changed = copy.deepcopy(facts["layers"])
                changed[number]["state"][name] = value
                made.append(snapshot.pack({**facts, "layers": changed}, blobs))
    for name, blob in blobs.items():
        made += [snapshot.pack(facts, {**blobs, name: data}) for data in (b"", blob[:-1], blob[1:], b"x" * 99)]
        made.append(snapshot.pack(facts, {other: data for other, data in blobs.items() if other != name}))
    return made


def ale_task() -> Any:
    env = wrap(
        AtariEnv("breakout", frameskip=1), task(**ALE, frameskip=(1, 4), episodic_life=True, max_episode_steps=70)
    )
    env.reset(seed=1)
    return env


@pytest.mark.parametrize("name", ["baselines", "dqn2015", "envpool", "ALE"])
def test_a_forged_snapshot_raises_and_changes_nothing(name: str) -> None:
    env = ale_task() if name == "ALE" else started(name)
    played(env, 40)
    before = env.snapshot()
    for data in forged(*snapshot.unpack(before)):
        with pytest.raises(ValueError, match="snapshot"):
            env.restore(data)
        assert env.snapshot() == before
    for data in (None, "text", bytearray(before)):
        with pytest.raises(TypeError, match="a snapshot is bytes"):
            env.restore(data)


def test_a_snapshot_of_a_preset_is_small() -> None:
    env = started()
    played(env, 30)
    assert len(env.snapshot()) < 20_000
