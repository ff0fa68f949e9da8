"""Videos say what was played, in their metadata."""

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from cli_tools import read, read_json
from film import film

import atari
from atari.cli import main
from atari.recording import RecordReplay, RecordVideo, Replay, video_facts
from atari.task import Task

PACKAGE = f"atari-envs {atari.__version__}"


def play(env: Any, steps: int = 3) -> None:
    env.reset(seed=7)
    for _ in range(steps):
        env.step(env.action_space.sample() * 0)
    env.close()


def comment(path: Path) -> Any:
    with av.open(str(path)) as container:
        return json.loads({name.lower(): text for name, text in container.metadata.items()}["comment"])


@pytest.mark.parametrize("ending", ["mp4", "mkv", "webm"])
def test_a_rendered_replay(ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = Task.of("pong", preset="dqn2015", frameskip=3)
    play(RecordReplay(atari.make(task), tmp_path / "a.a26r"))
    replay = Replay.load(tmp_path / "a.a26r")
    path = replay.render(tmp_path / f"a.{ending}", scale=1)
    facts = comment(path)
    assert facts == video_facts(path) == replay.facts
    assert Task.from_json(json.dumps(facts["task"])) == task
    assert (facts["core_seeds"], facts["package"]) == (list(replay.seeds), PACKAGE)
    assert read_json(capsys, "info", str(path)) == facts
    shown = read(capsys, "info", str(path))
    assert shown.startswith(f"{path}: written by {PACKAGE}\n{task}\n")
    assert shown.endswith(f"core seeds    {replay.seeds[0]}\n")


def test_wrappers(tmp_path: Path) -> None:
    env = RecordVideo(atari.make("pong", preset="baselines"), str(tmp_path / "a"), scale=1)
    env.unwrapped.ale.setFloat("repeat_action_probability", 0.5)  # type: ignore[attr-defined]
    env.unwrapped.load_game()  # type: ignore[attr-defined]
    play(env)
    (path,) = (tmp_path / "a").iterdir()
    played = Task.from_json(json.dumps(video_facts(path)["task"]))
    assert Task.of("pong", preset="baselines").differences(played) == {"repeat_action_probability": (0.0, 0.5)}
    tasks = [Task.of("pong"), Task.of("pong", interventions=["lazy_enemy"])]
    envs = RecordVideo(atari.AtariVectorEnv(tasks, 2), str(tmp_path / "b"), index=1, scale=1)
    envs.reset(seed=0)
    envs.step(np.zeros(2, np.int64))
    envs.close()
    (path,) = (tmp_path / "b").iterdir()
    assert Task.from_json(json.dumps(video_facts(path)["task"])).differences(tasks[1]) == {}


def test_several_players_and_games_of_your_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--seconds", "0.2", "--scale", "1", "--json", "-o"]
    assert main(["record", "combat", "--players", "2", *words, str(tmp_path / "a.mp4")]) == 0
    facts = video_facts(tmp_path / "a.mp4")
    assert (facts["game"], facts["players"], facts["options"]["mode"]) == ("combat", 2, 1)
    catch = Path(__file__).parents[3] / "examples" / "catch" / "catch.toml"
    assert main(["record", str(catch), *words, str(tmp_path / "b.mp4")]) == 0
    assert video_facts(tmp_path / "b.mp4")["task"]["game"] == "catch"
    capsys.readouterr()
    assert '"game": "catch"' in read(capsys, "info", str(tmp_path / "b.mp4"))


def test_videos_without_facts(tmp_path: Path) -> None:
    film(tmp_path / "a.mp4", [np.zeros((210, 160, 3), np.uint8)], comment="[]")
    film(tmp_path / "a.gif", [np.zeros((210, 160, 3), np.uint8)], comment="{}")
    (tmp_path / "b.mp4").write_bytes(b"no video")
    for name, text in (("a.mp4", "has no facts about"), ("a.gif", "has no facts about"), ("b.mp4", "has no facts")):
        with pytest.raises(ValueError, match=text):
            video_facts(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        video_facts(tmp_path / "none.mp4")
