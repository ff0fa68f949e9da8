"""`Monitor`: its files have the content that scripts read, and its videos have the played frames."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

import atari.classic as gym
from atari.classic.monitor_files import capped_cubic_video_schedule, load_results
from atari.classic.wrappers import Monitor
from atari.classic.wrappers.monitoring.stats_recorder import StatsRecorder


class Clip(gym.Env):
    """Renders the number of its step as a gray value, in 5 x 7 pixels; done after 3 steps."""

    metadata = {"render.modes": ["rgb_array"], "video.frames_per_second": 10}  # noqa: RUF012
    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Discrete(9)

    def reset(self) -> int:
        self.n = 0
        return 0

    def step(self, action: int) -> Any:
        self.n += 1
        return self.n, 1.5, self.n >= 3, {}

    def render(self, mode: str = "human") -> Any:
        return np.full((5, 7, 3), 60 * self.n, np.uint8)


def play(env: gym.Env, episodes: int, steps: int = 3) -> None:
    for _ in range(episodes):
        env.reset()
        for _ in range(steps):
            env.step(0)


def read(folder: Path, kind: str) -> Any:
    (file,) = folder.glob(f"openaigym.{kind}.*.json")
    return json.loads(file.read_text())


def decode(path: Path) -> tuple[Any, list[Any]]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        return stream.average_rate, [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_statistics_and_manifest(tmp_path: Path) -> None:
    with Monitor(gym.make("CartPole-v0"), tmp_path, video_callable=False, uid="me", mode="evaluation") as env:
        env.seed(0)
        env.action_space.seed(0)
        lengths = []
        for _ in range(4):
            env.reset()
            done, steps = False, 0
            while not done:
                done = env.step(env.action_space.sample())[2]
                steps += 1
            lengths.append(steps)
        assert env.get_total_steps() == sum(lengths)  # type: ignore[attr-defined]
        assert env.get_episode_lengths() == lengths  # type: ignore[attr-defined]
        assert env.get_episode_rewards() == [float(n) for n in lengths]  # type: ignore[attr-defined]
    stats = read(tmp_path, "episode_batch")
    assert set(stats) == {
        "initial_reset_timestamp", "timestamps", "episode_lengths", "episode_rewards", "episode_types"
    }  # fmt: skip
    assert (stats["episode_lengths"], stats["episode_rewards"]) == (lengths, lengths)
    assert stats["episode_types"] == ["e"] * 4
    assert stats["initial_reset_timestamp"] <= stats["timestamps"][0] <= stats["timestamps"][-1]
    manifest = read(tmp_path, "manifest")
    assert (tmp_path / manifest["stats"]).exists()
    assert manifest["videos"] == []
    assert manifest["env_info"]["env_id"] == "CartPole-v0"
    assert sorted(path.name.split(".")[-2] for path in tmp_path.iterdir()) == ["manifest", "stats"]


def test_a_video_is_what_was_shown(tmp_path: Path) -> None:
    with Monitor(Clip(), tmp_path) as env:
        play(env, 1)
    (path,) = tmp_path.glob("*.mp4")
    rate, frames = decode(path)
    assert rate == 10
    assert [frame.shape for frame in frames] == [(10, 14, 3)] * 4  # doubled: H.264 has even sides
    for n, frame in enumerate(frames):
        assert abs(frame.astype(int) - 60 * n).max() <= 4
    facts = read(tmp_path, "video.*")
    assert facts.pop("encoder_version") == {"backend": "PyAV", "version": av.__version__}
    assert facts == {"episode_id": 0, "content_type": "video/mp4", "frames_per_second": 10.0}


@pytest.mark.parametrize(
    ("env_id", "rate", "shape"), [("PongDeterministic-v4", 15, (420, 640, 3)), ("CartPole-v0", 50, (400, 600, 3))]
)
def test_a_video_has_the_rate_and_the_pixels_of_its_environment(
    env_id: str, rate: int, shape: tuple[int, ...], tmp_path: Path
) -> None:
    with Monitor(gym.make(env_id), tmp_path) as env:
        play(env, 1, steps=2)
    seen, frames = decode(next(tmp_path.glob("*.mp4")))
    assert (seen, [frame.shape for frame in frames]) == (rate, [shape] * 3)


def test_which_episodes_are_recorded(tmp_path: Path) -> None:
    recorded = [n for n in range(3000) if capped_cubic_video_schedule(n)]
    assert recorded == [*(n**3 for n in range(10)), 1000, 2000]
    with Monitor(Clip(), tmp_path, video_callable=lambda episode: episode % 2 == 1) as env:
        play(env, 4)
    names = sorted(path.name.split(".")[-2] for path in tmp_path.glob("*.mp4"))
    assert names == ["video000001", "video000003"]
    assert [video.split(".")[-2] for video, _ in read(tmp_path, "manifest")["videos"]] == names


def test_an_episode_may_be_left_early(tmp_path: Path) -> None:
    with Monitor(Clip(), tmp_path) as env:
        env.reset()
        env.reset()  # nothing was played: no episode
        env.step(0)
        play(env, 1)
        env.reset()
        env.step(0)
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [1, 3, 1]
    frames = [len(decode(path)[1]) for path in sorted(tmp_path.glob("*.mp4"))]
    assert frames == [1, 2]  # of resets 0 and 1, as in Gym


def test_the_end_of_an_episode_is_the_end(tmp_path: Path) -> None:
    with Monitor(Clip(), tmp_path, video_callable=False) as env:
        play(env, 1)
        with pytest.raises(
            gym.error.Error, match=r"the episode is over, and Monitor does not go on; call env.reset\(\) first"
        ):
            env.step(0)
        play(env, 1)
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [3, 3]


def test_files_of_other_monitors_are_kept_or_removed_only_on_request(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    Monitor(Clip(), tmp_path, video_callable=False).close()
    with pytest.raises(gym.error.Error, match=r"has files of another Monitor, such as openaigym\..*force=True"):
        Monitor(Clip(), tmp_path)
    Monitor(Clip(), tmp_path, video_callable=False, resume=True).close()
    assert len(list(tmp_path.glob("*.stats.json"))) == 2
    Monitor(Clip(), tmp_path, video_callable=False, force=True).close()
    assert len(list(tmp_path.glob("*.stats.json"))) == 1
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_statistics_may_be_written_upon_every_reset(tmp_path: Path) -> None:
    env = Monitor(Clip(), tmp_path, video_callable=False, write_upon_reset=True)
    play(env, 2)
    env.reset()
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [3, 3]
    env.close()
    env.close()


def test_an_environment_without_rgb_array_is_not_recorded(tmp_path: Path) -> None:
    class Blind(Clip):
        metadata = {"render.modes": ["human"]}  # noqa: RUF012

    with Monitor(Blind(), tmp_path) as env:
        play(env, 1)
    assert not list(tmp_path.glob("*.mp4"))
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [3]


def test_a_wrong_mode(tmp_path: Path) -> None:
    with pytest.raises(gym.error.Error, match="mode must be 'training' or 'evaluation', got 'test'"):
        Monitor(Clip(), tmp_path / "new", mode="test")  # type: ignore[arg-type]
    assert not (tmp_path / "new").exists()


def test_files_are_written_without_close(tmp_path: Path) -> None:
    program = (
        "import sys, atari.classic as gym\n"
        "env = gym.wrappers.Monitor(gym.make('Pong-v0'), sys.argv[1])\n"
        "env.reset()\n"
        "[env.step(0) for _ in range(7)]"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=True, timeout=60)
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [7]
    assert len(decode(next(tmp_path.glob("*.mp4")))[1]) == 8


class Hooked(Monitor):
    """Notes the calls of its hooks, ends episodes at observation 2, and records no video of episode 1."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self.calls: list[str] = []
        super().__init__(*arguments, **options)

    def _after_step(self, observation: Any, reward: Any, done: bool, info: Any) -> bool:
        self.calls.append(f"after_step {observation} {reward} {done}")
        return super()._after_step(observation, reward, done, info) or observation == 2

    def reset_video_recorder(self) -> None:
        self.calls.append(f"reset_video_recorder {self.episode_id}")
        super().reset_video_recorder()

    def _video_enabled(self) -> bool:
        return self.episode_id != 1

    def _env_info(self) -> dict[str, Any]:
        return {**super()._env_info(), "env_id": "mine"}

    def _flush(self, force: bool = False) -> None:
        self.calls.append(f"flush {force}")
        super()._flush(force)


def noted(name: str, text: str) -> Callable[..., Any]:
    """A hook that notes its call."""

    def hook(self: Hooked, *arguments: Any, **options: Any) -> Any:
        self.calls.append(text.format(*arguments))
        return getattr(Monitor, name)(self, *arguments, **options)

    return hook


for _name, _text in {
    "_start": "start",
    "_before_reset": "before_reset",
    "_after_reset": "after_reset {}",
    "_before_step": "before_step {}",
    "_close_video_recorder": "close_video_recorder",
}.items():
    setattr(Hooked, _name, noted(_name, _text))


def test_hooks_of_a_subclass_are_called_as_in_gym(tmp_path: Path) -> None:
    with Hooked(Clip(), tmp_path) as env:
        for _ in range(2):
            env.reset()
            env.step(7)
            assert env.step(7)[2]  # `_after_step` ends the episode
            env.stats_recorder.done = True  # type: ignore[attr-defined]
    episode = ["after_reset 0", "reset_video_recorder {}", "flush False"]
    episode += ["before_step 7", "after_step 1 1.5 False", "before_step 7", "after_step 2 1.5 False"]
    first, second = ([call.format(number) for call in episode] for number in range(2))
    closed = ["close_video_recorder", "flush True"]
    second.insert(2, "close_video_recorder")
    assert env.calls == ["start", "before_reset", *first, "before_reset", *second, *closed]  # type: ignore[attr-defined]
    assert [path.name.split(".")[-2] for path in tmp_path.glob("*.mp4")] == ["video000000"]
    assert read(tmp_path, "manifest")["env_info"]["env_id"] == "mine"
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [2, 2]


def test_a_recorder_of_statistics_of_ones_own(tmp_path: Path) -> None:
    """As in PFRL and ChainerRL: a monitor whose `_start` replaces the recorder, for resets before the end."""

    class Recorder(StatsRecorder):
        def before_reset(self) -> None:
            if self.done is False and self.steps:
                self.save_complete()
            self.done = False
            self.initial_reset_timestamp = self.initial_reset_timestamp or 1.0

    class Patient(Monitor):
        def _start(self, directory: Any, *arguments: Any, **options: Any) -> None:
            super()._start(directory, *arguments, **options)
            name = f"{self.file_prefix}.episode_batch.{self.file_infix}"
            self.stats_recorder = Recorder(directory, name, autoreset=False, env_id="Clip-v0")
            self._set_mode("evaluation")

    with Patient(Clip(), tmp_path, video_callable=False) as env:
        play(env, 1, steps=2)
        play(env, 1)
        with pytest.raises(gym.error.Error, match="the type of an episode is 't' for training or 'e' for evaluation"):
            env.stats_recorder.type = "x"  # type: ignore[attr-defined]
    stats = read(tmp_path, "episode_batch")
    assert (stats["episode_lengths"], stats["episode_types"]) == ([2, 3], ["e", "e"])
    with pytest.raises(gym.error.Error, match=r"^this recorder is closed; make another one$"):
        StatsRecorder.before_reset(env.stats_recorder)  # type: ignore[attr-defined]


def test_results_of_several_monitors_are_in_the_order_of_time(tmp_path: Path) -> None:
    first = Monitor(Clip(), tmp_path, video_callable=False, resume=True, mode="evaluation")
    second = Monitor(Clip(), tmp_path, resume=True)
    play(first, 1)
    play(second, 1, steps=2)
    second.reset()
    play(first, 1)
    first.close(), second.close()
    results = load_results(tmp_path)
    assert results is not None
    assert (results["episode_lengths"], results["episode_types"]) == ([3, 2, 3], ["e", "t", "e"])
    assert results["timestamps"] == sorted(results["timestamps"])
    assert results["data_sources"] in ([0, 1, 0], [1, 0, 1])
    assert all(Path(path).exists() for video in results["videos"] for path in video)
    assert len(results["videos"]) == 2
    assert load_results(tmp_path / "nothing") is None


def test_texts_are_recorded_as_json(tmp_path: Path) -> None:
    class Text(Clip):
        metadata = {"render.modes": ["human", "ansi"]}  # noqa: RUF012

        def render(self, mode: str = "human") -> Any:
            return f"step\n{self.n}\n"

    with Monitor(Text(), tmp_path, uid="me") as env:
        play(env, 1)
    (path,) = (each for each in tmp_path.glob("*.video000000.json"))
    video = json.loads(path.read_text())
    assert (video["width"], video["height"], len(video["stdout"])) == (6, 3, 4)
    assert video["stdout"][3] == [0.5, "\x1b[2J\x1b[1;1Hstep\r\n3\r\n"]


@pytest.mark.parametrize(
    "env", [Clip(), gym.make("CartPole-v0"), gym.make("CartPole-v0").env], ids=["own", "made", "bare"]
)  # type: ignore[attr-defined]
def test_the_monitor_of_2016(env: gym.Env, tmp_path: Path) -> None:
    """The script starts the monitor on the environment that it uses, and closes the monitor first."""
    env.monitor.start(str(tmp_path), force=True, seed=0)
    play(env, 2)
    with pytest.raises(gym.error.Error, match=r"env.monitor is started already; call env.monitor.close\(\) first"):
        env.monitor.start(tmp_path)
    env.monitor.close()
    env.monitor.close()
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [3, 3]
    assert sorted(len(decode(path)[1]) for path in tmp_path.glob("*.mp4")) == [4, 4]
    play(env, 1)  # not recorded
    assert read(tmp_path, "episode_batch")["episode_lengths"] == [3, 3]


def test_an_environment_may_have_a_monitor_of_its_own() -> None:
    env = Clip()
    env.monitor = {"top": 0}
    assert gym.Wrapper(env).env.monitor == {"top": 0}
