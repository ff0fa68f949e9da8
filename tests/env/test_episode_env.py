"""`EpisodeEnv`, which `atari.make` returns for presets, beside the nested wrappers: what a user of either could notice."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import AroundAle, Observer
from gymnasium.wrappers import RecordEpisodeStatistics
from tasks import nested

import atari
from atari import Action, AtariEnv
from atari.env.episode_env import EpisodeEnv
from atari.recording import RecordReplay, RecordVideo
from atari.registry.making import make_env
from atari.task import Task
from atari.wrappers.layers import wrap

PRESETS = ("dqn2015", "baselines", "gymnasium", "envpool", "ale_vector")


def both(task: Task, **options: Any) -> tuple[Any, Any]:
    """The nested wrappers of a task, and the one object."""
    one = make_env(task, **options)
    assert isinstance(one, EpisodeEnv)
    return nested(task, **options), one


def shown(results: Any) -> Any:
    """Results of `reset` or `step` in a form that can be compared."""
    observation, *signals, info = results
    info = {**info}
    if "episode" in info:
        info["episode"] = [info["episode"][part] for part in "rl"]
    parts = observation.items() if isinstance(observation, dict) else [("", observation)]
    return [(name, part.tobytes(), part.dtype, part.shape) for name, part in parts], signals, list(info), str(info)


def play(env: Any, steps: int, seed: int = 0, each: Callable[[Any, int], Any] = lambda env, step: None) -> list[Any]:
    """The results of random steps, with a reset after most ends, and what `each` returns after each step."""
    numbers = np.random.default_rng(seed)
    results = [shown(env.reset(seed=seed))]
    for step in range(steps):
        result = env.step(int(numbers.integers(env.action_space.n)))
        results.append((shown(result), each(env, step)))
        if (result[2] or result[3]) and numbers.random() < 0.8:
            results.append(shown(env.reset(options={"new_game": True} if numbers.random() < 0.2 else None)))
    return results


def record(env: Any, step: int) -> Any:
    """The driver's record of the game."""
    driver = env.unwrapped.driver
    return (
        driver.phase,
        driver.played.score,
        driver.played.steps,
        driver.played.first_frame,
        bool(driver.played.rewards),
    )


@pytest.mark.parametrize(
    ("preset", "core", "game", "limit"),
    [
        *((preset, "native", "breakout", None) for preset in atari.PRESETS if preset != "multiplayer_dqn"),
        *((preset, "native", "bank_heist", 403) for preset in PRESETS),
        *((preset, core, "breakout", None) for preset in PRESETS for core in ("plain", "ale")),
    ],
)
@pytest.mark.filterwarnings("ignore:.*after the episode had ended")
def test_results_and_the_record_of_the_game(preset: str, core: str, game: str, limit: int | None) -> None:
    steps = {"native": 300, "plain": 60, "ale": 60}[core]
    options = {} if limit is None else {"max_num_frames_per_episode": limit}
    nests, one = both(Task.of(game, preset=preset, **options), core=core)
    assert play(nests, steps, each=record) == play(one, steps, each=record)
    assert nests.unwrapped.snapshot() == one.unwrapped.snapshot()


def test_it_has_the_spaces_and_attributes_of_the_wrappers() -> None:
    for obs_type in ("grayscale", "rgb", "dict", "rgb_dict", "ram"):
        nests, one = both(Task.of("pong", preset="dqn2015", obs_type=obs_type))
        assert (nests.observation_space, nests.action_space) == (one.observation_space, one.action_space)
        assert nests.metadata == one.metadata
        for name in ("frame_skip", "driver", "get_action_meanings", "clone_state", "get_keys_to_action", "game"):
            assert type(nests.get_wrapper_attr(name)) is type(one.get_wrapper_attr(name)), name
        assert type(one.unwrapped) is AtariEnv
        assert nests.unwrapped.task == one.unwrapped.task


@pytest.mark.parametrize("preset", PRESETS)
def test_observers_receive_the_same_frames(preset: str) -> None:
    def watched(env: Any) -> Observer:
        core = env.unwrapped.core
        shown = (core.ram, core.screen_rgb)
        return Observer(
            env, lambda *frame: (*frame, core.frame_number, *(get().tobytes() for get in shown)), lambda: "begun"
        )

    nests, one = both(Task.of("breakout", preset=preset))

    first, second = watched(nests), watched(one)
    assert play(nests, 60) == play(one, 60)
    assert first.seen == second.seen
    one.unwrapped.driver.observers.clear()
    one.step(0)
    assert len(first.seen) == len(second.seen)


@pytest.mark.parametrize("mode", ["rgb_array_list", "rgb_array", None])
def test_rendering(mode: Any) -> None:
    def screens(env: Any, step: int) -> Any:
        drawn = env.render() if mode is not None and step % 3 == 0 else []
        return [screen.tobytes() for screen in drawn], len(env.unwrapped.recent_screens)

    nests, one = both(Task.of("breakout", preset="baselines"), render_mode=mode)
    assert play(nests, 40, each=screens) == play(one, 40, each=screens)


def test_a_window_shows_each_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pygame")
    counts = []
    for env in both(Task.of("breakout", preset="baselines"), render_mode="human"):
        frames: list[bytes] = []
        monkeypatch.setattr(
            env.unwrapped._window, "show", lambda screen, frames=frames: frames.append(screen.tobytes())
        )
        play(env, 10)
        counts.append(frames)
        env.close()
    assert counts[0] == counts[1]
    assert len(counts[0]) > 40


def test_sound_closing_and_reopening_in_the_middle_of_a_game() -> None:
    def change(env: Any, step: int) -> Any:
        atari_env = env.unwrapped
        if step % 50 == 20:
            atari_env.driver.make_sound()
        if step % 50 == 30:
            atari_env.close()
            env.reset(seed=step)
        return atari_env.core.audio().tobytes() if step % 50 == 25 else None

    for preset in ("baselines", "gymnasium", "dqn2015"):
        nests, one = both(Task.of("ms_pacman", preset=preset))
        assert play(nests, 120, each=change) == play(one, 120, each=change)


def test_numbers_are_drawn_from_the_generator_of_the_environment() -> None:
    def draw(env: Any, step: int) -> Any:
        return float(env.unwrapped.np_random.random()) if step % 7 == 0 else None

    nests, one = both(Task.of("breakout", preset="envpool", frameskip=(2, 5)))
    assert play(nests, 60, each=draw) == play(one, 60, each=draw)
    for env in (nests, one):
        env.unwrapped.np_random = np.random.default_rng(9)
    assert shown(nests.reset()) == shown(one.reset())


def test_interventions_and_memory() -> None:
    def poke(env: Any, step: int) -> Any:
        ram = atari.lab.Ram(env)
        if step % 9 == 4:
            ram["ball_x"] = 60
        return env.unwrapped.core.ram().tobytes()

    nests, one = both(Task.of("breakout", preset="dqn2015", interventions=["strong_ball"]))
    assert play(nests, 80, each=poke) == play(one, 80, each=poke)


def test_the_settings_of_ale_and_an_assigned_ale() -> None:
    class Silent(AroundAle):
        """Replaces every action by FIRE."""

        def act(self, action: Any, strength: float = 1.0) -> int:
            return int(self.inner.act(Action.FIRE, strength))

    def change(env: Any, step: int) -> Any:
        atari_env = env.unwrapped
        if step == 10:
            atari_env.ale.setFloat("repeat_action_probability", 0.9)
            env.reset(seed=4)
        if step == 20:
            atari_env.ale = Silent(atari_env.ale)
        if step == 50:
            atari_env.ale = atari_env.ale.inner
        return str(atari_env.task)

    nests, one = both(Task.of("breakout", preset="dqn2015", obs_type="ram"))  # images are the emulator's own
    assert play(nests, 70, each=change) == play(one, 70, each=change)


def test_the_actions_of_the_environment_may_change() -> None:
    nests, one = both(Task.of("breakout", preset="dqn2015"))
    for env in (nests, one):
        env.unwrapped._action_set = [Action.LEFT, Action.RIGHT, Action.FIRE, Action.NOOP]
    assert play(nests, 50) == play(one, 50)


def test_a_snapshot_of_nested_wrappers_is_refused() -> None:
    nests, one = both(Task.of("breakout", preset="dqn2015"))
    for first, second in ((nests, one), (one, nests)):
        first.reset(seed=0)
        second.reset(seed=0)
        before = second.snapshot()
        with pytest.raises(ValueError, match=r"the snapshot was taken with the wrappers .*; restore it into the same"):
            second.restore(first.snapshot())
        assert second.snapshot() == before


@pytest.mark.parametrize(
    ("options", "accepted"),
    [({"reward_clipping": False}, True), ({"obs_type": "rgb"}, False), ({"stack_num": 2}, False), ({}, True)],
)
def test_a_snapshot_fits_tasks_that_play_alike(options: dict[str, Any], accepted: bool) -> None:
    env, other = (atari.make("breakout", preset="dqn2015", **changed) for changed in ({}, options))
    env.reset(seed=0)
    other.reset(seed=1)
    if accepted:
        other.restore(env.snapshot())  # type: ignore[attr-defined]
        assert other.step(1)[0].tobytes() == env.step(1)[0].tobytes()
    else:
        with pytest.raises(ValueError, match="the snapshot was taken with"):
            other.restore(env.snapshot())  # type: ignore[attr-defined]


def test_a_game_that_waits_for_fire_gives_a_warning() -> None:
    texts = []
    for env in both(Task.of("breakout", preset="envpool", repeat_action_probability=0.0)):
        env.reset(seed=0)
        with warnings.catch_warnings(record=True) as caught:
            for _ in range(4510):
                env.step(0)
        texts.append([str(warning.message) for warning in caught])
    assert texts[0] == texts[1]
    assert len(texts[0]) == 1
    assert "it may wait for FIRE" in texts[0][0]


def test_steps_before_a_reset_and_after_the_end() -> None:
    for env in both(Task.of("breakout", preset="dqn2015", max_num_frames_per_episode=60)):
        with pytest.raises(gymnasium.error.ResetNeeded):
            env.step(0)
        env.reset(seed=0)
        while not env.step(0)[3]:
            pass
        with pytest.warns(UserWarning, match="after the episode had ended"):
            assert env.step(0)[3]


@pytest.mark.parametrize(
    ("preset", "options", "error"),
    [
        ("dqn2015", {"noops": -1}, ValueError),
        ("dqn2015", [("noops", 1)], TypeError),
        ("dqn2015", {"noops": "3"}, TypeError),
        ("dqn2015", {"fire": True}, TypeError),
        ("dqn2015", {"speed": 3}, TypeError),
        ("machado2018", {"noops": 3}, TypeError),
        ("baselines", {"speed": 3}, TypeError),
    ],
)
def test_wrong_options_of_a_reset_change_nothing(preset: str, options: dict[str, Any], error: type[Exception]) -> None:
    texts = []
    for env in both(Task.of("breakout", preset=preset)):
        env.reset(seed=0)
        for _ in range(5):
            env.step(1)
        before = env.snapshot()
        with pytest.raises(error) as caught:
            env.reset(options=options)
        texts.append(str(caught.value))
        assert env.snapshot() == before
    assert texts[0] == texts[1]


def test_a_wrong_seed_leaves_the_game_to_go_on() -> None:
    for env in both(Task.of("breakout", preset="dqn2015", episodic_life=True)):
        env.reset(seed=0)
        while not env.step(1)[2]:
            pass
        frame = env.unwrapped.core.episode_frame_number
        with pytest.raises(gymnasium.error.Error):
            env.reset(seed=-1)
        assert env.reset()[1]["episode_frame_number"] > frame


@pytest.mark.parametrize("options", [{"noops": 3}, {"noops": 0, "fire": False}, {"fire": False}, {"new_game": True}])
def test_options_of_a_reset(options: dict[str, Any]) -> None:
    nests, one = both(Task.of("breakout", preset="baselines"))
    for env in (nests, one):
        env.reset(seed=0)
        env.step(1)
    for seed in (None, 3):
        assert shown(nests.reset(seed=seed, options=options)) == shown(one.reset(seed=seed, options=options))
        assert shown(nests.step(1)) == shown(one.step(1))


def test_recorders_of_gymnasium_add_their_own_episode() -> None:
    for env in both(Task.of("breakout", preset="dqn2015", max_num_frames_per_episode=200)):
        recorded = RecordEpisodeStatistics(env)
        recorded.reset(seed=0)
        ended, length = False, 0
        while not ended:
            *_, terminated, truncated, info = recorded.step(1)
            ended, length = terminated or truncated, length + 1
        assert info["episode"]["l"] == length


def test_replays_and_videos_have_the_same_bytes(tmp_path: Path) -> None:
    for preset in PRESETS:
        files = []
        for number, env in enumerate(both(Task.of("breakout", preset=preset))):
            path = tmp_path / f"{preset}{number}.a26r"
            recorder = RecordReplay(env, path)
            play(recorder, 80)
            recorder.close()
            files.append(path.read_bytes())
        assert files[0] == files[1]


def test_videos_have_the_same_frames(tmp_path: Path) -> None:
    pytest.importorskip("av")
    sizes = []
    for number, env in enumerate(both(Task.of("breakout", preset="dqn2015"), render_mode="rgb_array")):
        recorder = RecordVideo(env, tmp_path / str(number))
        play(recorder, 8)
        recorder.close()
        sizes.append([(path.name, path.read_bytes()) for path in sorted((tmp_path / str(number)).iterdir())])
    assert sizes[0] == sizes[1]
    assert sizes[0]


def test_wrappers_and_subclasses_with_steps_of_their_own_are_nested() -> None:
    class OwnStep(AtariEnv):
        def step(self, action: Any) -> Any:
            return super().step(action)

    class OwnInfo(AtariEnv):
        def _get_info(self) -> dict[str, Any]:
            return {**super()._get_info(), "mine": 1}

    class Layer(gymnasium.Wrapper[Any, Any, Any, Any]):
        def step(self, action: Any) -> Any:
            return self.env.step(action)

    task = Task.of("breakout", preset="dqn2015")
    plain = task.emulator_task()
    for env in (OwnStep(plain), OwnInfo(plain), Layer(AtariEnv(plain))):
        assert type(wrap(env, task)).__name__ == "ClipReward"
    assert type(wrap(AtariEnv(plain), task)).__name__ == "EpisodeEnv"
    other = Task.of("pong", preset="dqn2015")
    assert type(wrap(AtariEnv(plain), other)).__name__ == "ClipReward"
