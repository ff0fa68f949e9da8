"""`atari collect`: what an ID plays, and what the data sets say of it."""

import json
from pathlib import Path
from typing import Any

import pytest
from cli_tools import Capture, Patch, read, read_json, refused

import atari
from atari.lab import write_dataset
from atari.recording import RecordReplay, Replay
from atari.task import Task

h5py = pytest.importorskip("h5py", reason="h5py is not installed")


@pytest.fixture(autouse=True)
def policies(folder: Path) -> None:
    (folder / "mine.py").write_text(
        "class Images:\n    environment = {'preset': 'dopamine'}\n    def __call__(self, o, lanes): return lanes * 0\n"
        "class Sticky(Images):\n    protocol = 'dopamine'\n"
        "def right(o, lanes): return lanes * 0 + 2\n"
    )


def collected(capsys: Capture, game: str, *words: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The output of the command, and the attributes and the actions of its data set."""
    file, own = f"{len(list(Path().glob('*.h5')))}.h5", ("game", "options", "labels", "observations", "sha256")
    shown = read_json(capsys, "collect", game, "--labels", "", "--observations", "grayscale", "-o", file, *words)
    with h5py.File(file) as root:
        facts = {name: json.loads(root.attrs[name]) for name in root.attrs if name not in own}
        return shown, {**facts, "actions": root["episode_0/actions"][:].tolist()}


def test_a_data_set_has_task_policy_and_seeds(capsys: Capture) -> None:
    shown, facts = collected(capsys, "pong", "--seed", "4294967294", "--episodes", "2", "--policy", "noop")
    task = Task.of("pong", preset="baselines", reward_clipping=False)
    assert Task.from_json(json.dumps(facts["task"])).differences(task) == {}
    assert (facts["policy"], facts["seeds"], shown["task"]) == ("noop", [2**32 - 2, 2**32 - 1], facts["task"])


def test_a_parquet_file_has_task_policy_and_seeds(capsys: Capture) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    text = read(capsys, "collect", "Breakout-ram-v0", "--labels", "", "-o", "a.parquet")
    metadata = parquet.read_schema("a.parquet").metadata
    assert Task.from_json(metadata[b"task"].decode()) == Task.of("Breakout-ram-v0")
    assert (metadata[b"policy"], metadata[b"seeds"]) == (b'"random"', b"[0]")
    assert text.startswith("breakout: Breakout, as Breakout-ram-v0\n")


def test_a_minari_dataset_has_task_policy_and_seeds(capsys: Capture, tmp_path: Path, monkeypatch: Patch) -> None:
    minari = pytest.importorskip("minari", reason="minari is not installed")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "datasets"))
    read(capsys, "collect", "ALE/Breakout-v5", "--labels", "", "--observations", "grayscale", "-o", "breakout/own-v0")
    metadata = minari.load_dataset("breakout/own-v0").storage.metadata
    assert Task.from_json(metadata["task"]) == Task.of("ALE/Breakout-v5")
    assert (metadata["policy"], metadata["seeds"]) == ('"random"', "[0]")


def test_ids_are_played_as_they_are(capsys: Capture) -> None:
    played = {name: collected(capsys, name)[1] for name in ("ALE/Breakout-v5", "BreakoutNoFrameskip-v4", "breakout")}
    for name in ("ALE/Breakout-v5", "BreakoutNoFrameskip-v4"):
        assert Task.from_json(json.dumps(played[name]["task"])) == Task.of(name)
    assert played["BreakoutNoFrameskip-v4"]["task"]["frameskip"] == 1
    assert len({json.dumps(facts["actions"]) for facts in played.values()}) == 3


def test_mode_and_interventions(capsys: Capture) -> None:
    _, facts = collected(capsys, "pong", "--mode", "1", "--intervention", "lazy_enemy")
    assert (facts["task"]["mode"], facts["task"]["interventions"][0]["name"]) == (1, "lazy_enemy")
    assert facts["task"]["fire"] == "after_noops"  # all else is as without the options


@pytest.mark.parametrize("preset", ["baselines", "dqn2015"])
def test_a_field_changes_the_preset_and_nothing_is_clipped(preset: str, capsys: Capture) -> None:
    named = [] if preset == "baselines" else ["--preset", preset]
    _, facts = collected(capsys, "pong", "--max-episode-steps", "20", *named)
    task = Task.of("pong", preset=preset, max_episode_steps=20, reward_clipping=False)
    assert Task.from_json(json.dumps(facts["task"])) == task


def test_a_policy_plays_what_it_was_trained_for(capsys: Capture) -> None:
    _, facts = collected(capsys, "ALE/Pong-v5", "--policy", "mine:Sticky")
    assert (facts["task"]["repeat_action_probability"], facts["task"]["stack_num"]) == (0.25, 4)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["ALE/Pong-v5", "--policy", "mine:Images"], "ALE/Pong-v5 has repeat_action_probability=0.25, and protocol 'b"),
        (["Pong-ram-v4", "--policy", "mine:Images"], "Pong-ram-v4 shows RAM, and the policy sees obs_type='grayscale'"),
        (["ALE/Pog-v5"], "ALE/Pong-v5"),
        (["pong", "--labels", "ball_x, bal_y"], "atari: error: pong has no label 'bal_y'; did you mean 'ball_y'?"),
        (["pong", "--reward-clipping"], "atari collect has no place for --reward-clipping"),
        (["pong", "--seed", "4294967295", "--episodes", "2"], "seeds are below 4294967296"),
        (["pong", "--seed", "4294967296"], "'4294967296' is not a whole number within 0..4294967295"),
        (["ALE/Pong-v5", "--policy", "a.a26r"], "what was played is in the replay a.a26r; name the game alone, 'pong'"),
        (["breakout", "--policy", "a.a26r"], "a.a26r is a replay of pong, not of breakout"),
    ],
)
def test_what_is_refused(words: list[str], text: str, capsys: Capture) -> None:
    if "a.a26r" in words:
        from atari.learning import record_games

        record_games("noop", "pong", "dopamine", [0], "a.a26r")
    refused(
        capsys,
        ["collect", *words, "-o", "a.h5"],
        text,
        2 if "--reward-clipping" in words or words[-1][-1] == "6" else 1,
    )
    assert not Path("a.h5").exists()


def test_a_replay_says_what_was_played(capsys: Capture) -> None:
    from atari.learning import record_games

    record_games("random", "breakout", "dopamine", [0], "a.a26r")
    shown, facts = collected(capsys, "breakout", "--policy", "a.a26r")
    task = Replay.load("a.a26r").task
    assert Task.from_json(json.dumps(facts["task"])) == Task.from_json(json.dumps(shown["task"])) == task
    assert task.stack_num == 4
    assert facts["core_seeds"] == list(Replay.load("a.a26r").seeds)
    assert facts["package"] == f"atari-envs {atari.__version__}"
    assert "policy" not in facts
    result = write_dataset(Replay.load("a.a26r"), "b.h5", labels=[], facts={"author": {"name": "me"}})
    with h5py.File("b.h5") as root:
        assert json.loads(root.attrs["author"]) == {"name": "me"}
    assert result["episodes"] == 1


def play_by_hand(path: Path) -> None:
    """Record some steps, as of a person."""
    with RecordReplay(atari.AtariEnv("pong"), path) as env:
        env.reset(seed=0)
        for action in (2, 3, 3, 0):
            env.step(action)


def usual(capsys: Capture, game: str, *words: str) -> tuple[str, tuple[int, ...]]:
    """The kind of the observations that the command stores without --observations, and the shape of the frames."""
    read(capsys, "collect", game, "--labels", "", "-o", "usual.h5", *words)
    with h5py.File("usual.h5") as root:
        return json.loads(root.attrs["observations"])["kind"], root["episode_0/frames"].shape[1:]


def test_the_usual_observations(capsys: Capture) -> None:
    """A policy with an environment saw something of its own; a replay may be a person's."""
    assert usual(capsys, "pong", "--policy", "mine:Sticky") == ("seen", (84, 84))
    Path("usual.h5").unlink()
    assert usual(capsys, "pong", "--policy", "noop", "--max-episode-steps", "9") == ("screen", (210, 160, 3))
    Path("usual.h5").unlink()
    play_by_hand(Path("a.a26r"))
    assert usual(capsys, "pong", "--policy", "a.a26r") == ("screen", (210, 160, 3))


def test_the_check(capsys: Capture) -> None:
    words = ["collect", "pong", "--policy", "noop", "--max-episode-steps", "20", "--observations", "seen"]
    read(capsys, *words, "--labels", "", "--episodes", "2", "-o", "a.h5")
    rows = [line.split() for line in read(capsys, "collect", "--check", "a.h5").splitlines()]
    assert rows == [["chosen", "steps", "equal", "near", "ties", "different"], ["greedy", "40", "40", "0", "0"]]
    counts = read_json(capsys, "collect", "--check", "a.h5", "--policy", "noop")
    assert counts == {"greedy": {"steps": 40, "equal": 40, "near_ties": 0, "different": 0}}
    refused(capsys, ["collect", "--check", "a.h5", "--policy", "mine:right"], "has other actions than the policy", 1)


def test_the_check_runs_no_program_that_a_file_names(capsys: Capture) -> None:
    read(capsys, "collect", "pong", "--policy", "mine:right", "--labels", "", "--observations", "seen", "-o", "a.h5")
    Path("mine.py").write_text("raise SystemExit('the program of a stranger')\n")
    text = "a.h5 was played by mine:right, which is a program; if you trust it: --policy mine:right"
    refused(capsys, ["collect", "--check", "a.h5"], text, 1)


def test_the_check_of_a_replays_data(capsys: Capture) -> None:
    play_by_hand(Path("a.a26r"))
    read(capsys, "collect", "pong", "--policy", "a.a26r", "--labels", "", "-o", "a.h5")
    assert "a.h5 is undamaged; it has no actions of a policy" in read(capsys, "collect", "--check", "a.h5")
    data = bytearray(Path("a.h5").read_bytes())
    data[len(data) // 2] ^= 1
    Path("a.h5").write_bytes(data)
    refused(capsys, ["collect", "--check", "a.h5"], "a.h5 is damaged", 1)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["-o", "a.h5"], "GAME is missing"),
        (["pong"], "--output is missing"),
        (
            ["pong", "--check", "a.h5", "--sticky", "0"],
            "--check reads a.h5 alone; leave game, repeat_action_probability",
        ),
        (["pong", "--observations", "seen", "--obs-type", "dict", "-o", "a.h5"], "obs_type='dict' shows dicts"),
        (["pong", "--observations", "seen", "--action-delay", "3", "-o", "a.h5"], "action_delay=3 lets actions arrive"),
        (["pong", "--observations", "seen", "--observation-delay", "1,3", "-o", "a.h5"], "was drawn in each game"),
    ],
)
def test_wrong_words_are_refused(words: list[str], text: str, capsys: Capture) -> None:
    refused(capsys, ["collect", *words], text, 1)
    assert not Path("a.h5").exists()
