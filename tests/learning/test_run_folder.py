"""Run folders: the files that are written, and the folders that are refused."""

import json
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import warnings
from contextlib import closing
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from replay_tools import full_disk  # noqa: E402
from small_trainings import make_options  # noqa: E402

import atari  # noqa: E402
from atari.base import durable  # noqa: E402
from atari.learning import ReplayMemory, TrainingEnvironments, evaluate, load_policy, record_games  # noqa: E402
from atari.learning.agent import read_options  # noqa: E402
from atari.learning.command import Lines  # noqa: E402
from atari.learning.pages import draw_levels, learning_curves  # noqa: E402
from atari.learning.report import finish  # noqa: E402
from atari.learning.run_folder import RunFolder  # noqa: E402
from atari.learning.run_policy import run_policy, training_protocol  # noqa: E402
from atari.learning.training import Training  # noqa: E402
from atari.recording import Replay  # noqa: E402


def make_run(path: Path, agent: str = "ppo", steps: int = 256, **options: Any) -> RunFolder:
    with closing(Training.begin(agent, make_options(agent, total_steps=steps, **options), path)) as training:
        assert training.run() == "steps"
    return RunFolder.open(path)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    return make_run(tmp_path_factory.mktemp("runs") / "pong")


@pytest.fixture(scope="module")
def breakout(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A run whose games are short: the policy has not learned anything."""
    return make_run(tmp_path_factory.mktemp("runs") / "breakout", game="breakout", steps=64)


@pytest.fixture
def copy(run: RunFolder, tmp_path: Path) -> Path:
    """A copy of the folder of `run`."""
    return shutil.copytree(run.path, tmp_path / "copy")


def test_the_log_has_a_row_for_each_update(run: RunFolder) -> None:
    rows = run.rows()
    assert [row["step"] for row in rows] == [64, 128, 192, 256]
    assert [row["frames"] for row in rows] == [256, 512, 768, 1024]
    assert all(np.isfinite(row["loss"]) for row in rows)
    assert run.task.game == run.config["task"]["game"] == "pong"
    assert "task" not in run.config["options"]
    assert {"atari-envs", "torch", "gymnasium", "numpy"} <= run.config["versions"].keys()


def test_a_training_stops_and_goes_on(tmp_path: Path) -> None:
    stop, shown = Event(), []
    with closing(Training.begin("ppo", make_options("ppo", total_steps=256), tmp_path / "run")) as training:
        assert training.run(stop, lambda steps, score: shown.append(steps) or stop.set()) == "stop"
    assert training.agent.steps == 64
    with closing(Training.resume(tmp_path / "run")) as resumed:
        assert resumed.run(progress=lambda steps, score: shown.append(steps)) == "steps"
    assert [row["step"] for row in resumed.folder.rows()] == shown == [64, 128, 192, 256]  # of the whole training


def test_the_policy_plays_the_same_games_whatever_the_lanes(breakout: RunFolder, tmp_path: Path) -> None:
    protocol, game = training_protocol(breakout), "breakout"
    scores = [evaluate(str(breakout.path), game, protocol, episodes=2, num_envs=lanes)[game] for lanes in (1, 2)]
    assert scores[0].scores == scores[1].scores
    seeds = scores[0].seeds
    played = record_games(load_policy(breakout.path), game, protocol, seeds, tmp_path / "a.a26r")
    assert [score for score, _ in played] == list(scores[0].scores)
    assert [episode.score for episode in Replay.load(tmp_path / "a.a26r").episodes] == list(scores[0].scores)


@pytest.mark.parametrize(("agent", "epsilon"), [("ppo", 0.0), ("pqn", 0.001), ("dqn", 0.3)])
def test_a_run_is_evaluated_with_the_random_actions_of_its_end(tmp_path: Path, agent: str, epsilon: float) -> None:
    given = {"epsilon": epsilon} if agent == "dqn" else {}
    folder = make_run(tmp_path / "run", agent, steps=64, **given)
    assert training_protocol(folder).epsilon == epsilon
    policy, lane = load_policy(folder.path), np.arange(1)
    policy.begin("pong", ("NOOP",) * 6, lane, lane)
    assert policy(np.zeros((1, 2, 42, 42), np.uint8), lane).shape == (1,)


PLAYED: dict[str, dict[str, Any]] = {
    "envpool": {"preset": "envpool", "episodic_life": True},
    "baselines": {"preset": "baselines"},
    "dqn2015": {"preset": "dqn2015"},
    "gymnasium": {"preset": "gymnasium", "episodic_life": None},  # a lost life would begin a new game in the training
    "whole games of envpool": {"preset": "envpool", "episodic_life": None},
    "whole games of ale_vector": {"preset": "ale_vector", "episodic_life": None},
    "sticky": {"preset": "envpool", "repeat_action_probability": 0.3},
    "FIRE for a step": {"preset": "envpool", "fire_unit": "skip", "fire_counts": False, "third_action": True},
    "lives for a step": {"preset": "dqn2015", "fire": "after_noops", "lives_unit": "skip", "on_reset": "noop"},
    "reported lives": {"preset": "baselines", "episodic_life": False, "life_loss_info": True},
    "short": {"preset": "baselines", "max_frames": 300},
    "other frames": {"preset": "envpool", "frameskip": (2, 5), "noops": (7, 40), "maxpool": False},
    "mode": {"preset": "envpool", "mode": 8, "difficulty": 1},
    "ram": {"preset": "envpool", "obs_type": "ram"},
    "zeros of ram": {"preset": "baselines", "obs_type": "ram", "padding": "zero", "stack_num": 3},
    "names": {"preset": "envpool", "actions": ("LEFT", "NOOP", "RIGHT")},
}


@pytest.mark.parametrize("name", PLAYED)
def test_games_of_the_evaluation_are_those_of_the_training(tmp_path: Path, name: str) -> None:
    folder = make_run(tmp_path / "run", game="breakout", steps=64, **PLAYED[name])
    policy = run_policy(folder.path, sample=False)
    count = len(folder.task.action_set)
    policy._scores = lambda seen: np.eye(count, dtype=np.float32)[seen.reshape(len(seen), -1).sum(1) % count]
    result = evaluate(policy, folder.task, training_protocol(folder), episodes=1)["breakout"]
    assert folder.rows()[-1]["frames"] == (3 if name == "other frames" else 4) * 64
    assert result.task["reward_clipping"] is False
    assert result.task["noops"] == list(folder.task.noops)
    envs = TrainingEnvironments(read_options(folder), 1)
    images, lane = envs.reset(seed=result.seeds[0]), np.arange(1)
    policy.begin("breakout", envs.actions, lane, np.array(result.seeds))
    while not (ended := envs.take_games()):
        images, *_ = envs.step(policy(images, lane))
    envs.close()
    assert ended[0] == ("breakout", result.scores[0], result.frames[0])


def test_report(breakout: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without PyAV there is no video."""
    run = breakout
    result = finish(run, episodes=2)
    page = (run.path / "report.html").read_text()
    # test_curves_say_what_is_drawn has games
    for text in ("PPO on Breakout, from pixels", "No game has ended in the training", 'src="best.mp4'):
        assert text in page
    assert {*re.findall("http://([^/]*)/", page)} <= {"www.w3.org", "purl.org", "creativecommons.org"}
    assert Replay.load(run.path / "best.a26r").episodes[0].score == max(result["breakout"].scores)
    assert (run.path / "best.mp4").stat().st_size > 10_000
    assert json.loads((run.path / "evaluation.json").read_text())
    (run.path / "report.html").unlink()
    monkeypatch.setitem(sys.modules, "av", None)
    finish(run, episodes=1)
    assert (run.path / "report.html").exists()
    assert not (run.path / "best.mp4").exists()


@pytest.mark.parametrize(
    ("file", "content", "text"),
    [
        ("config.json", b"{", "config.json is damaged"),
        ("config.json", b'{"format": 3}', "config.json is damaged"),
        ("config.json", b"[" * 100_000, "nested more than 32 deep"),
        ("config.json", None, "is no run folder"),
        ("policy.pt", b"PK rubbish", "policy.pt is damaged"),
        ("policy.pt", None, "the first checkpoint writes it"),
        ("checkpoint.pt", b"rubbish", "checkpoint.pt is damaged"),
        ("checkpoint.pt", None, "checkpoint.pt is missing"),
    ],
)
def test_damaged_folders(copy: Path, file: str, content: bytes | None, text: str) -> None:
    if content is None:
        (copy / file).unlink()
    else:
        (copy / file).write_bytes(content)
    work = load_policy if file == "policy.pt" else Training.resume
    with pytest.raises((ValueError, FileNotFoundError), match=text):
        work(copy)


@pytest.mark.parametrize("version", [99, 2, True, None])
def test_other_versions_are_refused(run: RunFolder, tmp_path: Path, version: Any) -> None:
    (tmp_path / "config.json").write_text(json.dumps({**run.config, "format": version}))
    with pytest.raises(ValueError, match=f"has format {version}, and this atari-envs reads 3; use the one that wrote"):
        RunFolder.open(tmp_path)


def test_a_folder_has_the_task(run: RunFolder) -> None:
    assert run.config["format"] == 3
    assert run.config["task"] == json.loads(make_options("ppo").task.to_json())
    policy: Any = load_policy(run.path)
    assert (policy.task, policy.protocol.task, policy.game) == (run.task, run.task, "pong")


def test_a_folder_that_is_not_empty_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(FileExistsError, match="is not empty"):
        Training.begin("ppo", make_options("ppo"), tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of a file's size")
def test_a_full_disk_ends_a_training_at_its_end_alone(tmp_path: Path) -> None:
    options = make_options("ppo", total_steps=256, checkpoint_minutes=0.0)
    with closing(Training.begin("ppo", options, tmp_path / "run")) as training:
        training.save()
        with (
            warnings.catch_warnings(record=True) as caught,
            pytest.raises(OSError, match="too large"),
            full_disk(200),
        ):
            training.run()
    assert training.agent.steps == 256
    warned = {str(one.message).partition(":")[0] for one in caught}
    assert {"no checkpoint at step 64, the one before stays", "the log is kept in memory until there is room"} <= warned
    with closing(Training.resume(tmp_path / "run")) as resumed:
        assert resumed.agent.steps == 0


def begin(path: Path) -> RunFolder:
    return RunFolder.begin(path, "mine", atari.Task.of("pong"), {"rate": 0.5})


def test_rows_kept_in_memory_are_written_later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with begin(tmp_path / "run") as folder:

        def full(path: Path, data: bytes) -> None:
            raise OSError("no room")

        with monkeypatch.context() as patch:
            patch.setattr(durable, "append", full)
            with pytest.warns(RuntimeWarning, match="kept in memory until there is room: no room"):
                folder.log({"step": 1, "score": 2})
        folder.log({"step": 2, "score": 3})
    assert folder.rows() == [{"step": 1, "score": 2}, {"step": 2, "score": 3}]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"score": 2.0}, "needs the column step, got score"),
        ({"step": 1.0}, "must have the columns step, score, got step"),
        ({"step": 1.0, "score": 2.0, "loss": 3.0}, "must have the columns step, score, got step, score, loss"),
    ],
)
def test_rows_of_other_columns_are_refused(tmp_path: Path, row: dict[str, float], message: str) -> None:
    with begin(tmp_path / "run") as folder:
        folder.log({"step": 0, "score": 1})
        with pytest.raises(ValueError, match=message):
            folder.log(row)
    assert len(folder.rows()) == 1


@pytest.mark.parametrize("end", ["192,768,0.", "192,7", "\0" * 500, "192,,,\n"])
def test_a_damaged_end_of_the_log_blocks_nothing(copy: Path, end: str) -> None:
    with (copy / "log.csv").open("a") as file:
        file.write(end)
    with pytest.warns(RuntimeWarning, match="log.csv is damaged: line 6 and those after it are left out"):
        load_policy(copy)
    with pytest.warns(RuntimeWarning, match="log.csv is damaged"):
        RunFolder.resume(copy).close()
    assert [row["step"] for row in RunFolder.open(copy).rows()] == [64, 128, 192, 256]


def test_a_folder_has_one_training_at_a_time(tmp_path: Path) -> None:
    with begin(tmp_path / "run") as folder:
        folder.checkpoint(0, {}, {})
        for call in (RunFolder.resume, lambda path: RunFolder.open(path, lock=True)):
            with pytest.raises(BlockingIOError, match=r"a training writes into .*run; wait for its end, or stop it"):
                call(tmp_path / "run")
        assert RunFolder.open(tmp_path / "run").config["agent"] == "mine"
    reading = RunFolder.open(tmp_path / "run")
    for write, *given in ((reading.checkpoint, 1, {}, {}), (reading.log, {"step": 1}), (reading.end, "steps")):
        with pytest.raises(ValueError, match="is open for reading"):
            write(*given)
    RunFolder.resume(tmp_path / "run").close()


def test_a_flipped_bit_is_found(copy: Path) -> None:
    generator = random.Random(0)
    for name, load in (("policy.pt", load_policy), ("checkpoint.pt", RunFolder.resume)):
        good = (copy / name).read_bytes()
        for _ in range(50):
            bad = bytearray(good)
            bad[generator.randrange(len(bad))] ^= 1 << generator.randrange(8)
            (copy / name).write_bytes(bad)
            with pytest.raises(ValueError, match=f"{name} is damaged"):
                load(copy)
        (copy / name).write_bytes(good)
        torch.load(copy / name, weights_only=name == "policy.pt")  # as any other file of PyTorch


def test_files_are_not_written_through_links(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    with begin(tmp_path / "run") as folder:
        for name in ("checkpoint.pt", "checkpoint.pt.part", "policy.pt.part", "config.json.part", "report.html"):
            (folder.path / name).symlink_to(victim)
        folder.checkpoint(0, {}, {})
        folder.end("steps")
        (folder.path / "log.csv").symlink_to(victim)
        with pytest.warns(RuntimeWarning, match="symbolic link"):
            folder.log({"step": 1})
    assert victim.read_text() == "mine"
    (folder.path / "lock").unlink()
    (folder.path / "lock").symlink_to(victim)
    with pytest.raises(OSError, match="symbolic link"):
        RunFolder.open(folder.path, lock=True)


HOSTILE: dict[str, Any] = {
    "a large image": {"task": {"img_height": 1_000_000}},
    "luck": {"task": {"luck": 1}},
    "nothing": {"task": None},
    "a number": {"options": 5},
    "a list": {"options": {"network": ["nature"]}},
    "null": {"options": {"num_envs": None}},
    "a text": {"options": {"learning_rate": "1"}},
    "many": {"options": {"num_envs": 10**12}},
    "unknown": {"options": {"luck": 1}},
    "an agent": {"agent": {}},
    "another agent": {"agent": "mine"},
    "an escape": {"agent": "\x1b[31m"},
    "no programs": {"programs": []},
    "a program": {"programs": {"agent": {"file": "x.py"}}},
    "a kind": {"programs": {"../agent": {"file": "x.py", "name": "X", "sha256": ""}}},
    "a key": {"more": 1},
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_configuration_is_refused(run: RunFolder, copy: Path, name: str) -> None:
    config = dict(run.config)
    for key, value in HOSTILE[name].items():
        config[key] = {**config.get(key, {}), **value} if isinstance(value, dict) and value else value
    (copy / "config.json").write_text(json.dumps(config))
    for load in (load_policy, Training.resume):
        with pytest.raises(ValueError, match=r"config.json|must be one of ppo, pqn, dqn"):
            load(copy)


def test_weights_of_another_network_are_refused_before_it_is_made(run: RunFolder, copy: Path) -> None:
    config = {**run.config, "task": {**run.config["task"], "img_height": 84, "img_width": 84}}
    (copy / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"policy.pt has weights of another network: encoder\S+ is \S+ \(.*\), not"):
        load_policy(copy)


def test_a_line_a_minute_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    lines = Lines(100, 1100, seconds=0)
    lines._start -= 10
    lines.show(600, "score 1.0")
    assert capsys.readouterr().err == "600 of 1,100 steps, score 1.0, 50/s, 0:00:10 left\n"
    lines = Lines(0, 200_000_000, seconds=0)
    lines._start -= 6000
    lines.show(100_000_000, "no whole game yet")
    assert len(capsys.readouterr().err) <= 80
    Lines(0, 10).show(5, "")
    assert not capsys.readouterr().err


def test_the_memory_is_as_large_as_the_training_and_goes_with_it(tmp_path: Path) -> None:
    options = make_options("dqn", total_steps=1200, memory=1_000_000, learning_starts=1000)
    memory = tmp_path / "run" / "memory.replay"
    with closing(Training.begin("dqn", options, tmp_path / "run")) as training:
        assert memory.stat().st_size < 10e6
        assert training.run() == "steps"
    assert not memory.exists()
    with pytest.raises(ValueError, match=r"is complete, and its memory was removed, .* or --keep-memory, keeps"):
        RunFolder.resume(tmp_path / "run")
    with RunFolder.open(tmp_path / "run", lock=True) as run, pytest.raises(ValueError, match="memory was removed"):
        run.extend(2400)
    assert RunFolder.open(tmp_path / "run").config["ended"] == "steps"
    kept = make_run(tmp_path / "kept", "dqn", steps=200, keep_memory=True)
    with RunFolder.resume(kept.path) as folder:
        assert folder.memory is not None
        assert folder.memory.steps >= 200


def test_a_full_disk_at_the_end_keeps_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    training = Training.begin("dqn", make_options("dqn", total_steps=200), tmp_path / "run")
    write = durable.write_file

    def full(path: Path, data: bytes) -> None:
        if path.name == "config.json":
            raise OSError(28, "No space left on device")
        write(path, data)

    monkeypatch.setattr(durable, "write_file", full)
    with pytest.raises(OSError, match="No space left"):
        training.run()
    training.close()
    monkeypatch.setattr(durable, "write_file", write)
    with closing(Training.resume(tmp_path / "run")) as resumed:
        assert resumed.run() == "steps"


def test_ctrl_c_saves_and_says_how_to_go_on(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "atari", "train", "ppo", "pong", "--fast", "-o", str(tmp_path / "run")]
    small = ["--num-envs", "4", "--horizon", "16", "--minibatch", "32", "--total-steps", "1e6"]
    training = subprocess.Popen([*command, *small], stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "run" / "log.csv").exists() and training.poll() is None:
        time.sleep(0.05)
    training.send_signal(signal.SIGINT)
    assert training.stderr is not None
    printed = training.stderr.read()
    assert training.wait() == 130, printed
    assert f"go on with `atari train --resume {tmp_path / 'run'}`" in printed
    assert Training.resume(tmp_path / "run").agent.steps >= 64


def test_curves_say_what_is_drawn() -> None:
    pytest.importorskip("matplotlib.figure")

    def drawn(*scores: float, frames: float = 400.0) -> str:
        rows = [{"frames": frames * number, "score": score} for number, score in enumerate(scores, 1)]
        return learning_curves("breakout", [("this run", "red", rows)])

    assert drawn(float("nan")) == "<p>No game has ended in the training, so there is no curve yet.</p>"
    assert drawn() == drawn(float("nan"))
    short, long = drawn(float("nan"), 3.0), drawn(1.0, 3.0, frames=20e6)
    assert short.startswith(
        "<p>Mean score of the last whole games, 100 if all environments are scored, all lives, not clipped.</p>\n<svg"
    )
    assert "currentColor" in short  # it follows the page, light or dark, without a white ground
    assert not {"#000000", "#ffffff", "white"} & {*re.findall(r"#\w{6}|\bwhite\b", short)}
    assert "Published curves" not in short
    assert "Published curves are of other protocols" in long


def test_a_human_far_above_the_curves_is_not_drawn() -> None:
    figure = pytest.importorskip("matplotlib.figure")
    for game, best, labels in (("breakout", 20, ["random", "human"]), ("seaquest", 1000, ["random"])):
        axes = figure.Figure().add_subplot()
        axes.plot([0, 1], [0, best], label="_curve")
        draw_levels(axes, game)
        assert axes.get_legend_handles_labels()[1] == labels
        assert axes.get_ylim()[1] < 2 * best


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((1.5, {}, {}), "step must be an integer"),
        ((1, [1, 2], {}), "state must be a mapping"),
        ((1, {}, torch.nn.Linear(1, 1)), r"as network.state_dict\(\), got Linear"),
        ((1, {}, {"w": [1.0]}), "got list under 'w'"),
        ((1, {}, {"net": {"w": torch.ones(1)}}), "got dict under 'net'; several networks go into one"),
    ],
)
def test_a_checkpoint_that_could_not_be_read_is_refused(arguments: Any, text: str, tmp_path: Path) -> None:
    with begin(tmp_path / "run") as run:
        with pytest.raises(TypeError, match=text):
            run.checkpoint(*arguments)
        assert not (run.path / "checkpoint.pt").exists()


@pytest.mark.parametrize(
    ("file", "autoflush", "text"),
    [
        (None, True, "and this one is in no file"),
        ("other.replay", False, "other.replay"),
        ("run/memory.replay", True, "flushes by itself"),
    ],
)
def test_a_memory_that_could_not_go_on_is_refused(file: str | None, autoflush: bool, text: str, tmp_path: Path) -> None:
    with begin(tmp_path / "run") as run:
        path = None if file is None else tmp_path / file
        memory = ReplayMemory(100, 2, (84, 84), path=path, autoflush=autoflush)
        with memory, pytest.raises(ValueError, match=text):
            run.checkpoint(1, {}, {"w": torch.ones(1)}, memory)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"agent": 5}, "agent must be a name"),
        ({"task": "pong"}, "task must be an atari.Task, such as .*, got 'pong'"),
        ({"options": ["lr"]}, "options must be a mapping"),
    ],
)
def test_a_run_has_a_name_a_task_and_options(wrong: dict[str, Any], text: str, tmp_path: Path) -> None:
    given: Any = {"agent": "mine", "task": atari.Task.of("pong"), "options": {}, **wrong}
    with pytest.raises(TypeError, match=text):
        RunFolder.begin(tmp_path / "run", **given)
    assert not (tmp_path / "run").exists()
