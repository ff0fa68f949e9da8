"""`atari record`: every kind of policy, recorded as videos and replays."""

import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import av
import pytest
from cli_tools import Capture, Patch, read, record_json, refused
from replay_tools import record
from video_reader import video_frames

from atari.cli import main
from atari.recording import Replay

POLICIES = """
import atari

def right(observations):
    assert observations.shape == (1, 210, 160, 3)
    return [2]

def stacked(observations, lanes):
    assert observations.shape == (1, 4, 84, 84)
    assert lanes.tolist() == [0]
    return [1]

def both(observations):
    assert {key: value.shape for key, value in observations.items()} == {"image": (1, 210, 160, 3), "sound": (1, 512)}
    return [0]

def wrong(observations):
    return [99]

def of_one_observation(observation):
    return 0

def of_ram(observations):
    assert observations.shape == (1, 128)
    return [2]

of_ram.task = atari.Task.of("pong", preset="dqn2015", obs_type="ram")

class Listens:
    begun = []

    def begin(self, game, actions, lanes, seeds):
        self.begun.append((game, len(actions), lanes.tolist(), seeds.tolist()))

    def begin_episodes(self, lanes):
        self.begun.append(lanes.tolist())

    def __call__(self, observations, lanes):
        return [1]

constant = 1
"""


@pytest.fixture(autouse=True)
def policies(folder: Path, monkeypatch: Patch) -> None:
    (folder / "policies_of_a_test.py").write_text(POLICIES)
    monkeypatch.delitem(sys.modules, "policies_of_a_test", raising=False)


def test_a_video_and_a_replay_of_the_same_play(folder: Path, capsys: Capture) -> None:
    words = ("breakout", "--policy", "random", "--seconds", "2")
    result = record_json(capsys, *words, "-o", "a.mp4", "-o", "b/a.a26r", "--scale", "1")
    assert result["files"] == [str(folder / "a.mp4"), str(folder / "b" / "a.a26r")]
    assert (result["game"], result["policy"], result["seed"], result["frames"]) == ("breakout", "random", 0, 120)
    replay = Replay.load("b/a.a26r")
    assert replay.verify("ale")
    assert [episode.score for episode in replay.episodes] == result["scores"]
    with av.open("a.mp4") as container:
        video, audio = container.streams.video[0], container.streams.audio[0]
        assert (video.width, video.height, video.frames) == (320, 210, 120)
        assert audio.codec_context.name == "aac"


def test_an_episode_is_a_game_and_the_default(capsys: Capture) -> None:
    result = record_json(capsys, "breakout", "-o", "a.a26r", "--preset", "dqn2015", "--episodes", "2", "--seed", "3")
    assert len(result["scores"]) == 2
    assert [episode.end for episode in Replay.load("a.a26r").episodes] == ["game over"] * 2
    again = record_json(capsys, "breakout", "-o", "b.a26r", "--preset", "dqn2015", "--episodes", "2", "--seed", "3")
    assert (again["frames"], again["scores"]) == (result["frames"], result["scores"])


def test_the_default_output_is_a_video(folder: Path, capsys: Capture) -> None:
    out = read(capsys, "record", "pong", "--seconds", "0.2")
    assert out.startswith("pong: Pong, as 'pong' with preset='dqn2015'\n  policy  random, seed 0\n  played  ")
    assert out.endswith(f"  file    {folder / 'videos' / 'pong-0.mp4'}\n")


@pytest.mark.parametrize("game", ["skiing", "PongNoFrameskip-v4"])
def test_doing_nothing(game: str, capsys: Capture) -> None:
    record_json(capsys, game, "--policy", "noop", "--seconds", "0.5", "-o", "a.a26r")
    assert {frame.action for frame in Replay.load("a.a26r").frames()} == {0}


def test_functions_are_policies(capsys: Capture) -> None:
    words = ("--seconds", "0.5", "-o", "a.a26r")
    record_json(capsys, "breakout", "--policy", "policies_of_a_test:right", *words)
    assert {frame.action for frame in Replay.load("a.a26r").frames()} == {3}
    record_json(capsys, "breakout", "--policy", "policies_of_a_test:stacked", "--preset", "dqn2015", *words)
    record_json(capsys, "breakout", "--policy", "policies_of_a_test:both", "--sound-obs", *words)
    assert "" not in sys.path


def test_a_function_with_a_task_plays_it(capsys: Capture) -> None:
    record_json(capsys, "pong", "--policy", "policies_of_a_test:of_ram", "-o", "a.a26r")
    assert Replay.load("a.a26r").task.obs_type == "ram"


@pytest.mark.parametrize("seamless", [False, True])
def test_policies_hear_of_games_and_episodes(seamless: bool, capsys: Capture) -> None:
    words = ["breakout", "--policy", "policies_of_a_test:Listens", "-o", "a.a26r", "--episodic-life"]
    words += ["--on-reset", "continue", *(["--seamless-lives"] if seamless else [])]
    result = record_json(capsys, *words, "--episodes", "2", "--seed", str(2**32 - 1))
    begun = sys.modules["policies_of_a_test"].Listens.begun
    lives = [] if seamless else [[0]] * 4
    assert begun == [("breakout", 4, [0], [2**32 - 1]), *lives, ("breakout", 4, [0], [0]), *lives]
    other = record_json(capsys, *words)
    assert result["scores"][1] == other["scores"][0]  # the second game has the next seed


def test_a_lost_life_that_begins_a_new_game_ends_the_one_before(capsys: Capture) -> None:
    record_json(capsys, "breakout", "--episodic-life", "--episodes", "2", "-o", "a.a26r")
    assert len(Replay.load("a.a26r").episodes) == 2


def test_random_games_are_those_of_their_seeds(capsys: Capture) -> None:
    words = ("breakout", "--policy", "random")
    both = record_json(capsys, *words, "--episodes", "2", "--seed", "3", "-o", "a.a26r")
    ones = [record_json(capsys, *words, "--seed", seed, "-o", "b.a26r") for seed in ("3", "4")]
    assert both["scores"] == [one["scores"][0] for one in ones]
    assert both["frames"] == sum(one["frames"] for one in ones)


def test_a_replay_is_a_policy(folder: Path, capsys: Capture) -> None:
    record(folder / "a.a26r", "pong", 40)
    result = record_json(capsys, "pong", "--policy", "a.a26r", "--no-sound")
    assert (result["frames"], result["files"]) == (160, [str(folder / "videos" / "pong-a.mp4")])
    result = record_json(capsys, "pong", "--policy", "a.a26r", "--seconds", "1", "-o", "b.mp4")
    with av.open("b.mp4") as container:
        assert container.streams.video[0].frames == result["frames"] == 60


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["pong", "--policy", "clever"], "there is no file clever; a policy is random, noop, a run folder, an SB3 zip"),
        (["pong", "--policy", "no_such_module:f"], "cannot be imported: No module named 'no_such_module'"),
        (["pong", "--policy", "policies_of_a_test:f"], "has no attribute 'f'"),
        (["pong", "--policy", "policies_of_a_test:constant"], "a function of observations and lanes, got 1"),
        (["pong", "--policy", "policies_of_a_test:wrong"], "returned action 99; in pong it has 6 actions, 0..5"),
        (["pong", "--policy", "policies_of_a_test:of_one_observation"], "of shape (1,), one for each observation"),
        (["pong", "--policy", "policies_of_a_test:of_one_observation"], "is a function of observations (n, ..."),
        (["pong", "--policy", "policies_of_a_test:of_ram", "--steps", "9"], "plays whole games, with the ROM that is"),
        (["pong", "--continuous"], "continuous=True has no numbered actions, and a policy chooses one; leave it out"),
        (["pong", "--policy", "none.a26r"], "there is no file none.a26r"),
        (["./seaquest.a26r"], "is another file or folder; name the game, and give a policy or a replay"),
        (["pong", "--policy", "seaquest.a26r"], "seaquest.a26r is a replay of seaquest, not of pong"),
        (["seaquest", "--policy", "seaquest.a26r", "-o", "b.a26r"], "a replay of a replay is its copy"),
        (["backgammon", "--policy", "noop"], "(--actions full) adds it"),
        (["ALE/Pong-v5", "--policy", "a.a26r"], "what was played is in the replay a.a26r; name the game alone, 'pong'"),
        (
            ["pong", "--policy", "a.a26r", "--sticky", "0", "--preset", "dqn2015"],
            "in the replay a.a26r; leave repeat_action_probability, preset out",
        ),
        (["pong", "--policy", "noop", "--policy", "noop"], "a second --policy needs --players"),
    ],
)
def test_what_cannot_be_done_is_one_line(words: list[str], text: str, folder: Path, capsys: Capture) -> None:
    record(folder / "seaquest.a26r", "seaquest", 2)
    record(folder / "a.a26r", "pong", 2)
    refused(capsys, ["record", *words], text)


def test_the_scores_of_a_part_of_a_replay_are_those_of_the_part(folder: Path, capsys: Capture) -> None:
    record(folder / "a.a26r", "pong", 300)
    result = record_json(capsys, "pong", "--policy", "a.a26r", "--seconds", "2", "-o", "a.gif", "--scale", "1")
    *_, last = Replay.load("a.a26r").frames(0, result["frames"])
    assert result["scores"] == [last.score] != [Replay.load("a.a26r").episodes[0].score]


@pytest.mark.parametrize("options", [["-o", "a.a26r", "-o", "a.mp4"], ["-o", "a.gif", "--best"]])
def test_ctrl_c_keeps_what_was_recorded(folder: Path, options: list[str]) -> None:
    words = [sys.executable, "-m", "atari", "record", "PongNoFrameskip-v4", "--policy", "slow:policy"]
    words += ["--steps", "2000"]
    (folder / "slow.py").write_text("import time\ndef policy(observations):\n    time.sleep(0.001)\n    return [0]\n")
    with subprocess.Popen(
        [*words, *options, "--scale", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith("200 of 2,000 steps")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert process.returncode == 130
    assert out == "pong: Pong, as PongNoFrameskip-v4\n"
    *_, word, line = err.splitlines()
    assert word == "atari: stopping; Ctrl-C again stops at once"
    files = " and ".join(str(folder / name) for name in options[1::2] if name.startswith("a."))
    match = re.fullmatch(r"atari: interrupted after ([\d,]+) frames; what was recorded is in (.+)", line)
    assert match is not None, err
    assert match[2] == files
    frames = int(match[1].replace(",", ""))
    assert 199 <= frames < 2000
    if "--best" in options:
        assert len(video_frames(folder / "a.gif")) >= frames * 5 // 6  # at 50 frames a second
        return
    replay = Replay.load("a.a26r")
    assert (replay.complete, replay.frames_total) == (True, frames)
    assert len(video_frames(folder / "a.mp4")) == frames


CATCH = Path(__file__).parents[2] / "examples" / "catch"


def test_a_game_definition_with_the_rom_beside_it(capsys: Capture) -> None:
    result = record_json(capsys, str(CATCH / "catch.toml"), "--policy", "random", "--seconds", "1", "-o", "catch.a26r")
    assert (result["game"], result["frames"]) == ("catch", 60)
    assert Path("catch.a26r").stat().st_size > 0


def test_a_game_definition_with_its_rom_elsewhere(capsys: Capture) -> None:
    shutil.copy(CATCH / "catch.toml", "mine.toml")
    assert main(["record", "mine.toml"]) == 1
    assert "rom" in capsys.readouterr().err
    words = ("mine.toml", "--rom", str(CATCH / "catch.bin"), "--preset", "dqn2015", "--seconds", "1", "-o", "mine.mp4")
    assert record_json(capsys, *words)["frames"] >= 60


def test_the_best_game_is_filmed(capsys: Capture) -> None:
    words = ["breakout", "--policy", "random", "--episodes", "3", "--max-num-frames-per-episode", "300"]
    words += ["--best", "--scale", "1", "--overlay", "score,action,curve"]
    result = record_json(capsys, *words, "-o", "best.gif", "-o", "all.a26r")
    replay = Replay.load("all.a26r")
    assert [episode.score for episode in replay.episodes] == result["scores"]
    best = result["scores"].index(max(result["scores"]))
    assert best == 1  # neither the first nor the last
    for episode in range(3):
        replay.render(f"{episode}.gif", scale=1, overlay=("score", "action", "curve"), episode=episode)
        assert (Path(f"{episode}.gif").read_bytes() == Path("best.gif").read_bytes()) == (episode == best)
    alone = record_json(capsys, *words, "-o", "alone.gif")
    assert alone["scores"] == result["scores"]
    assert Path("alone.gif").read_bytes() == Path("best.gif").read_bytes()
    assert sorted(path.name for path in Path().glob("*.a26r")) == ["all.a26r"]


def test_wrong_videos_are_refused_before_the_games_are_played(capsys: Capture) -> None:
    words = ["record", "pong", "--best", "--seconds", "1", "-o", "a.a26r", "-o"]
    refused(capsys, [*words, "%.png"], "must have a place for its number")
    refused(capsys, [*words, "a.gif", "--scale", "17"], "--scale: '17' is not a whole number within 1..16", 2)
    assert not Path("a.a26r").exists()
    refused(
        capsys, ["record", "pong", "--overlay", "score,best"], "'best' is none of score, lives, action, ram, curve", 2
    )
