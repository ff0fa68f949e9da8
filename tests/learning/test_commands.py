"""`atari train`, and the commands that take a run folder."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from cli_tools import Capture, Patch, read_json  # noqa: E402

from atari.cli import main  # noqa: E402
from atari.recording import Replay  # noqa: E402
from atari.task import Task  # noqa: E402

SMALL = "--fast --num-envs 4 --horizon 16 --minibatch 32 --total-steps 128".split()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("runs") / "pong"
    task = ["--actions", "NOOP,RIGHT,LEFT", "--max-num-frames-per-episode", "1200"]
    assert main(["train", "ppo", "pong", *SMALL, *task, "-o", str(folder), "--games", "1"]) == 0
    return str(folder)


def test_train_writes_a_report(run: str) -> None:
    names = {path.name for path in Path(run).iterdir()}
    assert {"config.json", "log.csv", "policy.pt", "checkpoint.pt", "best.a26r", "best.mp4", "report.html"} <= names
    task = json.loads(Path(run, "config.json").read_text())["task"]
    assert (task["actions"], task["img_height"]) == (["NOOP", "RIGHT", "LEFT"], 42)


def test_resume_of_a_training_that_is_complete(run: str, capsys: Capture) -> None:
    before = Path(run, "checkpoint.pt").read_bytes()
    assert main(["train", "--games", "0", "--resume", run]) == 0
    assert Path(run, "checkpoint.pt").read_bytes() == before
    first, *middle, last = capsys.readouterr().out.splitlines()
    assert "is complete (all steps are done)" in " ".join(middle)
    assert first.startswith("pong: Pong, as 'pong' with preset='envpool', but actions=('NOOP', 'RIGHT', 'LEFT')")
    assert last == run
    assert main(["train", "--json", "--games", "0", "--resume", run]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["run"], shown["task"]["game"], shown["evaluation"]) == (run, "pong", None)


def test_evaluate_and_record_a_run(run: str, tmp_path: Path, capsys: Capture) -> None:
    assert main(["evaluate", run, "--protocol", "dqn2015", "--episodes", "1", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)["result"]
    assert result["training_frames"] == 512
    shown = read_json(capsys, "record", "pong", "--policy", run, "--episodes", "2", "-o", str(tmp_path / "a.a26r"))
    assert [episode.score for episode in Replay.load(tmp_path / "a.a26r").episodes] == shown["scores"]


@pytest.mark.parametrize("obs", ["pixels", "ram"])
def test_a_run_plays_against_others(obs: str, run: str, tmp_path: Path, capsys: Capture) -> None:
    if obs == "ram":
        run = str(tmp_path / "ram")
        words = ["train", "--games", "0", "ppo", "Pong-ram-v4", *SMALL, "--seed", "3000000000", "-o", run]
        assert main(words) == 0
        first = capsys.readouterr().out.splitlines()[0]
        assert first.startswith("pong: Pong, as 'pong' with preset='envpool', but ")
        assert "obs_type='ram'" in first
    words = ["record", "pong", "--players", "2", "--policy", run, "--policy", "random", "--seconds", "8"]
    replays = [tmp_path / "a.a26r", tmp_path / "b.a26r"]
    for replay in replays:
        shown = read_json(capsys, *words, "-o", str(replay))
        assert shown["policies"] == [run, "random"]
    played = [[frame.actions[0] for frame in Replay.load(replay).frames()] for replay in replays]
    assert played[0] == played[1]
    assert {0, 3, 4} >= {*played[0]} or obs == "ram"  # NOOP, RIGHT, LEFT
    assert len({*played[0]}) > 1
    assert all(len({*played[0][frame : frame + 4]}) == 1 for frame in range(0, 400, 4))


def test_a_run_of_another_game_cannot_play(run: str, tmp_path: Path, capsys: Capture) -> None:
    assert main(["record", "boxing", "--players", "2", "--policy", run, "--policy", "noop"]) == 1
    assert "is a policy for pong, not for boxing" in capsys.readouterr().err
    assert main(["record", "pong", "--players", "2", "--policy", str(tmp_path)]) == 1
    assert f"{tmp_path} is no run folder" in capsys.readouterr().err


def test_watch(run: str, monkeypatch: Patch, capsys: Capture) -> None:
    shown: list[Replay] = []

    def show(replay: Replay, **options: object) -> bool:
        shown.append(replay)
        return len(shown) < 2

    monkeypatch.setattr("atari.cli.watch.show_replay", show)
    assert main(["watch", run]) == 0
    first, *printed = capsys.readouterr().out.splitlines()
    assert first.startswith("pong: Pong, as 'pong' with preset='envpool'")
    assert printed == [f"seed {seed}: score {shown[seed].episodes[0].score}" for seed in (0, 1)]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["train"], "name an agent (ppo, pqn, dqn, or a Python file such as my_ppo.py) and a game"),
        (["train", "a2c", "pong"], "there is no agent 'a2c'; there are ppo, pqn, dqn, and Python files of your own"),
        (["train", "pqm", "pong"], "there is no agent 'pqm'; did you mean pqn?"),
        (["train", "ppo", "pon"], "there is no game 'pon'; did you mean 'pong'?"),
        (["train", "ppo", "pong", "--clip", "x"], "argument --clip"),
        (["train", "ppo", "pong", "--colour", "1"], "unrecognized arguments: --colour 1"),
        (["train", "ppo", "pong", "--actions", "UP,FLY"], "each of actions must be one of 'NOOP'"),
        (["train", "ppo", "ALE/Pog-v5"], "did you mean 'ALE/Pong-v5'"),
        (["train", "ppo", "ALE/Pong-v5", "--preset", "dqn2015"], "and ALE/Pong-v5 has 0.25; use the game's name"),
        (["train", "ppo", "own.toml"], "own.toml"),
        (["train", "ppo", "pong", "--protocol", "dqn2015"], "are for a sweep, `atari train AGENT GAMES --seeds 0-2`"),
        (["train", "ppo", "pong", "--episodes=3"], "`atari evaluate RUN --protocol NAME` evaluates it"),
        (["train", "dqn", "pong", "--fast", "--total-steps", "4096"], "must be above learning_starts, or nothing is"),
        (["train", "ppo", "pong", "--image-hight", "42"], "did you mean '--img-height'?"),
        (["train", "ppo", "pong", "--frameskip", "5,2"], "argument --frameskip: a frameskip range (low, high)"),
        (["train", "ppo", "pong", "--noops", "3"], "argument --noops: noops must be (low, high)"),
        (["train", "ppo", "pong", "--sticky", "2"], "repeat_action_probability must be within 0..1, got 2"),
        (["train", "ppo", "pong", "--intervention", "lazy"], "lazy"),
        (["train", "ppo", "pong", "--mode", "99"], "99"),
        (["train", "--resume", "x", "--total-steps", "5e6", "--seed", "1"], "--total-steps N; leave out --seed 1"),
        (["train", "ppo", "pong", "--players", "2"], "atari train ppo has no place for --players, the field 'players'"),
        (["train", "ppo", "pong", "--seed", "4294967296"], "seed must be within 0..4294967295, got 4294967296"),
        (["train", "ppo", "Pong-ram-v4", "--img-height", "42", "--img-width", "42"], "img_height=42 has no effect"),
        (["train", "ppo", "pong", "--device", "tpu"], "device must be cpu, cuda, cuda:N or auto, got 'tpu'"),
        (["train", "ppo", "pong", "--device", "cuda:x"], "device must be cpu, cuda, cuda:N or auto, got 'cuda:x'"),
        (["train", "ppo", "pong", "--device", "cuda:99"], "device is 'cuda:99', and PyTorch can use"),
        (["train", "--resume", "nowhere"], "nowhere is no run folder"),
        (["train", "--resume", "nowhere", "ppo"], "goes on with its own options, but for --total-steps N; leave out p"),
        (["record", "pong", "--policy", ".", "-o", "x.mp4"], "no run folder"),
        (["watch", "nowhere", "pong"], "nowhere"),
    ],
)
def test_mistakes(words: list[str], text: str, tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) in (1, 2)
    assert text in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_without_torch(monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    assert main(["train", "ppo", "pong"]) == 1
    assert f"atari train needs torch: {sys.executable} -m pip install 'torch>=2.2'" in capsys.readouterr().err


PRINTED: dict[str, dict[str, Any]] = {
    "pong": {},
    "ALE/Pong-v5": {"repeat_action_probability": 0.25},
    "Pong-ram-v4": {"obs_type": "ram", "stack_num": 4, "padding": "reset"},
    "pong --preset envpool --episodic-life": {"preset": "envpool", "episodic_life": True},
    "pong --frameskip 2,5 --no-maxpool --noops 1,9": {"frameskip": (2, 5), "maxpool": False, "noops": (1, 9)},
    "pong --sticky 0.1 --full-action-space": {"repeat_action_probability": 0.1, "actions": "full"},
    "pong --reward reward-0.1*(player_y<50)": {"reward": "reward-0.1*(player_y<50)"},
    "pong --intervention lazy_enemy --mode 1": {"interventions": ["lazy_enemy"], "mode": 1},
    "pong --max-num-frames-per-episode none --max-frames 1e5": {
        "max_num_frames_per_episode": None, "max_frames": 100_000
    },
    "breakout --fast --seed 3000000000": {
        "preset": "envpool", "episodic_life": True, "img_height": 42, "img_width": 42
    },
    "Breakout-ram-v0 --fast": {
        "preset": "envpool", "episodic_life": True, "obs_type": "ram", "repeat_action_probability": 0.25,
        "stack_num": 2, "padding": "reset"
    },
}  # fmt: skip


@pytest.mark.parametrize("line", PRINTED)
def test_print_task(line: str, capsys: Capture) -> None:
    words, usual = line.split(), {"preset": "baselines", "reward_clipping": True, "seamless_lives": False}
    expected = Task.of("breakout" if "reakout" in line else "pong", **{**usual, **PRINTED[line]})
    assert main(["train", "ppo", *words, "--print-task"]) == 0
    assert capsys.readouterr().out == f"{expected}\n"
    forms = ["--json", "ppo", *words], ["ppo", "--json", *words], ["ppo", *words, "--json"]
    for written in (*forms, [*words[1:], "--json", "ppo", words[0]]):
        assert main(["train", *written, "--print-task"]) == 0
        assert Task.from_json(capsys.readouterr().out) == expected
