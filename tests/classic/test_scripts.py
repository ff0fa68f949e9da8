"""Scripts as textbooks of 2018 have them, run unmodified by `python -m atari.classic`."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import av
from env_tools import needs_gymnasium_1

SCRIPTS = Path(__file__).parent / "scripts"


def completed(name: str, *arguments: str, driver: str | None = "dummy") -> "subprocess.CompletedProcess[str]":
    """A script that has run without a display, and with a video driver of SDL or without any."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
    environment = {key: value for key, value in os.environ.items() if key not in hidden}
    command = [sys.executable, "-m", "atari.classic", str(SCRIPTS / f"{name}.py"), *arguments]
    options = {"SDL_VIDEODRIVER": driver} if driver else {}
    result = subprocess.run(command, capture_output=True, text=True, env={**environment, **options}, timeout=120)
    assert result.returncode == 0, result.stderr
    return result


def run(name: str, *arguments: str) -> list[str]:
    """The lines that a script prints."""
    return completed(name, *arguments).stdout.splitlines()


def test_every_script_means_gym() -> None:
    scripts = list(SCRIPTS.glob("*.py"))
    assert len(scripts) == 6
    for script in scripts:
        text = script.read_text()
        assert "import gym" in text
        assert "atari" not in text


def test_cartpole_loop_without_a_display() -> None:
    """On Linux it warns once, and continues, without SDL_VIDEODRIVER too."""
    done = completed("cartpole_loop", driver=None if sys.platform == "linux" else "dummy")
    assert done.stdout == "done\n"
    warnings = done.stderr.count("there is no display, so env.render() shows nothing")
    assert warnings == (sys.platform == "linux")


@needs_gymnasium_1
def test_spaces_and_bounds() -> None:
    assert run("spaces_and_bounds") == [
        "Discrete(2)",
        "Box(4,)",
        "[4.8               inf 0.41887903        inf]",
        "[-4.8               -inf -0.41887903        -inf]",
        "[-1.2  -0.07]",
        "Discrete(16)",
        "[2.]",
        "True True",
        "EnvSpec(ALE/Adventure-ram-v5)",
    ]


def test_twenty_episodes() -> None:
    """The first state after `env.seed(0)` is the one that books and tutorials printed."""
    first, *finished = run("twenty_episodes")
    assert first == "[-0.04456399  0.04653909  0.01326909 -0.02099827]"
    assert len(finished) in (19, 20)  # an episode of 100 steps or more prints nothing
    lengths = [int(re.fullmatch(r"Episode finished after (\d+) timesteps", line)[1]) for line in finished]  # type: ignore[index]
    assert min(lengths) >= 8
    assert 12 < sum(lengths) / len(lengths) < 40  # a random agent keeps the pole up for 22 steps on average


def test_trained_agent() -> None:
    assert run("trained_agent", "1", "1.0") == [
        "mean of 100 episodes: 200.0 solved: True",
        "the last one was cut off: True",
    ]


def test_breakout_with_monitor(tmp_path: Path) -> None:
    (tmp_path / "openaigym.manifest.0.1.manifest.json").write_text("of an earlier run")
    lines = run("breakout_monitor", str(tmp_path))
    assert lines[0] == "['NOOP', 'FIRE', 'RIGHT', 'LEFT']"
    games = [
        re.fullmatch(r"episode \d: 5 lives at first, (\d) after (\d+) steps, reward (\d+)\.0", line)
        for line in lines[1:]
    ]
    assert len(games) == 2
    steps, rewards = ([int(game[i]) for game in games if game] for i in (2, 3))
    (stats,) = tmp_path.glob("openaigym.episode_batch.0.*.stats.json")
    written = json.loads(stats.read_text())
    assert (written["episode_lengths"], written["episode_rewards"]) == (steps, rewards)
    videos = sorted(tmp_path.glob("openaigym.video.0.*.mp4"))
    assert [path.name[-15:] for path in videos] == ["video000000.mp4", "video000001.mp4"]
    for path, length in zip(videos, steps, strict=True):
        with av.open(str(path)) as container:
            (stream,) = container.streams
            assert (stream.width, stream.height) == (640, 420)
            assert sum(1 for _ in container.decode(video=0)) == length + 1
    (manifest,) = tmp_path.glob("openaigym.manifest.*.json")  # the one of the earlier run is gone
    assert [name for name, _ in json.loads(manifest.read_text())["videos"]] == [path.name for path in videos]


def test_custom_environment() -> None:
    *walk, last, shape = run("custom_environment")
    assert walk == [
        walk[0][: walk[0].index("A")] + "." * i + "A" + "." * (len(walk) - 1 - i) + "G" for i in range(len(walk))
    ]
    assert last == "[7] 2.0 True {}"
    assert shape == "<Doubled<TimeLimit<Checked<CorridorEnv<Corridor-v0>>>>> 7"
