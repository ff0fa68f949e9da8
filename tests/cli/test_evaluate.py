"""`atari evaluate`: its output, and errors that come before the first game."""

import base64
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from cli_tools import read, read_json, refused

from atari.cli import main
from atari.learning import PROTOCOLS, Published, Result, evaluate

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def policy(folder):
    """A policy that never serves, or loses fast."""
    (folder / "idle.py").write_text("def act(o): return [0] * len(o)\n")
    for name, frames in (("short", 1_000_000), ("long", 5_000_000)):
        (folder / f"{name}.py").write_text(f"def act(o): return [0] * len(o)\nact.training_frames = {frames}\n")
    (folder / "images.py").write_text(
        "class Images:\n    environment = {'preset': 'dopamine'}\n    def __call__(self, o, lanes): return lanes * 0\n"
    )


def test_text_files_and_comparison(capsys, tmp_path):
    words = ("evaluate", "random", "pong", "--protocol", "dopamine", "--episodes", "2", "--seed", "4")
    text = read(capsys, *words, "-o", "result.json", "--compare", "dopamine/rainbow", "--human", "noop57")
    result = evaluate("random", "pong", "dopamine", episodes=2, seed=4)
    assert str(result) in text
    assert Result.load(tmp_path / "result.json") == result
    assert "dopamine/rainbow     5  199,000,000" in text
    assert str(tmp_path / "result.json") in text


def test_json(capsys):
    content = read_json(capsys, "evaluate", "idle:act", "pong", "--protocol", "dopamine", "--episodes", "1")
    assert content["result"]["protocol"]["name"] == "dopamine"
    assert content["result"]["games"][0]["scores"] == [-21.0]
    assert content["comparison"] is None


def test_the_game_that_is_played(capsys):
    words = ("evaluate", "idle:act", "Pong-ram-v0", "--mode", "1", "--intervention", "lazy_enemy", "--episodes", "1")
    (game,) = read_json(capsys, *words)["result"]["games"]
    assert (game["task"]["mode"], game["task"]["obs_type"]) == (1, "ram")
    assert [one["name"] for one in game["task"]["interventions"]] == ["lazy_enemy"]


def test_the_game_of_a_run_is_played_with_the_fields_that_are_given(capsys):
    pytest.importorskip("torch")
    flags = "--mode 4 --action-delay 2,5 --print-task".split()
    words = ("evaluate", str(ROOT / "examples" / "breakout-pqn"), *flags)
    task = read_json(capsys, *words)
    assert (task["game"], task["mode"], task["action_delay"], task["img_height"]) == ("breakout", 4, [2, 5], 42)


def test_lists(capsys):
    text = read(capsys, "evaluate", "--list")
    content = read_json(capsys, "evaluate", "--list")
    assert list(content["protocols"]) == list(PROTOCOLS)
    assert content["published"] == list(Published.names())
    assert content["comparable"]["dqn2015"] == ["papers/dqn2015", "pfrl/dqn"]
    assert re.search(r"^papers/rainbow +54 +scores +noop_starts +seungjaeryanlee/rldb", text, re.MULTILINE)
    assert re.search(r"^papers/agent57 +57 +scores +none ", text, re.MULTILINE)
    for name in (*PROTOCOLS, *content["sets"], *content["published"]):
        assert name in text


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("nosuch.zip", "pong"), "there is no file nosuch.zip"),
        (("random",), "does not say which game it plays"),
        (("random", "pogn"), "pong"),
        (("random", "ALE/Pog-v5"), "did you mean 'ALE/Pong-v5'"),
        (("random", "PongNoFrameskip-v4"), "=0.0, and protocol 'machado2018' 0.25; pass 'pong'"),
        (("images:Images", "Pong-ram-v0"), "Pong-ram-v0 shows RAM, and the policy sees obs_type='grayscale'"),
        (("random", "pong", "--mode", "99"), "99"),
        (("random", "pong", "--intervention", "lazy"), "lazy"),
        (("random", "pong", "--protocol", "dopamin"), "did you mean 'dopamine'"),
        (("random", "pong", "--compare", "dopamine/rainbw"), "dopamine/rainbow"),
        (
            ("random", "pong", "--compare", "cleanrl/ppo"),
            "these are not comparable: cleanrl/ppo_atari_envpool_xla_jax: repeat_action_probability",
        ),
        (("random", "pong", "--compare", "cleanrl/ppo"), "protocol 'baselines' has its environments; --mixed compares"),
        (
            ("random", "pong", "--protocol", "dopamine", "--compare", "dopamine/rainbow", "--frames", "262144"),
            "these are not comparable: dopamine/rainbow: the first scores",
        ),
        (
            ("random", "pong", "--protocol", "dopamine", "--compare", "dopamine/rainbow", "--human", "nature2015"),
            "the human table nature2015 is not for scores of dopamine",
        ),
        (
            ("short:act", "pong", "--beside", "long:act", "--protocol", "dopamine", "--compare", "dopamine/rainbow"),
            "the policies were trained for different numbers of frames: 1,000,000 and 5,000,000",
        ),
        (("random", "pong", "--human", "noop"), "noop57"),
        (
            ("random", "pong", "--mode", "1", "--protocol", "dopamine", "--compare", "dopamine/rainbow"),
            "pong is played with another mode than in",
        ),
        (("random", "freeway", "--variants", "modess"), "must be one of 'modes', 'difficulties'"),
        (("random", "pong", "--variants", "modes", "--beside", "noop"), "leave --beside and --compare out"),
        (("random", "pong", "--beside", "noop", "-o", "a.json"), "as -o scores.html, got a.json; --json prints"),
        (("random", "pong", "--beside", "random"), "random is named twice among the agents"),
        (("random", "pong", "--beside", "nosuch.zip"), "there is no file nosuch.zip"),
        (("random", "pong", "--beside", "class/*.pt"), "there are no files class/*.pt; give the folder"),
        (("random", "pong", "--beside", "."), "has no policies: no run folders and no files .onnx"),
        (("random", "pong", "-o", "nosuch/a.json"), "there is no folder"),
        (("nosuch:act", "pong"), "cannot be imported"),
    ],
)
def test_errors_are_one_sentence(capsys, words, text):
    assert not refused(capsys, ["evaluate", *words], text)


def test_no_source(capsys):
    refused(capsys, ["evaluate"], "SOURCE (or --list)", 2)


def test_ctrl_c(capsys, monkeypatch, tmp_path):
    (tmp_path / "stopped.py").write_text("def act(o): raise KeyboardInterrupt\n")
    assert main(("evaluate", "stopped:act", "pong", "-o", "result.json")) == 130
    assert capsys.readouterr().err == "atari: interrupted before all games had ended; nothing is saved\n"
    assert not (tmp_path / "result.json").exists()


def test_sources_by_game(capsys, tmp_path):
    for game in ("pong", "freeway"):
        (tmp_path / f"{game}_agent.py").write_text("def act(o): return [0] * len(o)\n")
    words = ("evaluate", "{game}_agent:act", "Pong-v0", "--protocol", "dopamine", "--episodes", "1")
    content = read_json(capsys, *words)
    assert [game["game"] for game in content["result"]["games"]] == ["pong"]
    json.dumps(content)


def test_variants_are_counted_before_the_first_game_and_are_rows(capsys, tmp_path):
    words = ("evaluate", "idle:act", "freeway", "--variants", "difficulties,modes*difficulties", "--episodes", "2")
    assert main([*words, "--protocol", "dopamine", "-o", "result.json"]) == 0
    shown = capsys.readouterr()
    assert shown.err == "32 games (policies: 1, tasks: 16, games of each: 2)\n"
    result = Result.load(tmp_path / "result.json")
    assert str(result) in shown.out
    assert len(result.variants("freeway")) == 16
    assert re.search(
        r"^mode=1, difficulty=1 +2 +0\.0 \[0\.0, 0\.0\] +\+0\.0 \[\+0\.0, \+0\.0\]", shown.out, re.MULTILINE
    )


def test_a_page_and_a_figure_of_variants(capsys, tmp_path):
    pytest.importorskip("matplotlib")
    words = ("evaluate", "idle:act", "freeway", "--variants", "difficulties", "--episodes", "1")
    assert main([*words, "--protocol", "dopamine", "-o", "page.html", "--plot", "figure.svg"]) == 0
    page = (tmp_path / "page.html").read_text()
    assert "<td>difficulty=1" in page
    assert "freeway: mean score" in (tmp_path / "figure.svg").read_text()
    assert "<video" not in page


def test_agents_beside_each_other(capsys, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "model.zip").write_bytes(b"PK")
    (tmp_path / "folder" / "notes.txt").write_text("not a policy")
    words = ("evaluate", "idle:act", "pong", "--beside", "random", "--beside", "folder", "--episodes", "2")
    assert main([*words, "--protocol", "dopamine"]) == 0
    shown = capsys.readouterr()
    assert shown.err == "4 games (policies: 2, tasks: 1, games of each: 2)\n"
    scores = evaluate("random", "pong", "dopamine", episodes=2)["pong"]
    assert scores.mean > -21
    assert re.search(
        rf"^random .* {scores.mean:.1f} .*\nidle:act +2 +-21.0 \[.*\] +{-21 - scores.mean:.1f} \[", shown.out, re.M
    )
    assert shown.out.count("games of each: 2; dopamine has 100") == 1
    assert "model.zip: not played: model.zip may be a model of Stable-Baselines3" in shown.out
    assert "notes.txt" not in shown.out
    content = json.loads(_json_of(capsys, *words, "--protocol", "dopamine", "--compare", "dopamine/rainbow"))
    assert list(content["results"]) == ["idle:act", "random"]
    assert list(content["not_played"]) == ["model.zip"]
    assert [row["name"] for row in content["comparison"]["rows"]] == ["idle:act", "random", "dopamine/rainbow"]


def _json_of(capsys, *words):
    assert main([*words, "--json"]) == 0
    return capsys.readouterr().out


def test_the_page_of_agents_has_the_game_with_the_median_score_of_each(capsys, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    av = pytest.importorskip("av")
    monkeypatch.setattr("atari.learning.beside._MOST_FRAMES", 60)
    words = ("evaluate", "idle:act", "pong", "--beside", "random", "--beside", "noop", "--episodes", "3")
    compared = ("--compare", "dopamine/rainbow")
    assert main([*words, "-o", "page.html", "--protocol", "dopamine", *compared]) == 0
    assert capsys.readouterr().err.endswith("\n3 videos, one of each policy and game\n")
    page = (tmp_path / "page.html").read_text()
    assert "<h1>3 policies in pong</h1>" in page
    assert page.index("<td>random<td>") < page.index("<td>idle:act<td>")
    assert page.index("<figcaption>random") < page.index("<figcaption>idle:act")
    assert page.count('<video controls loop muted playsinline src="data:video/mp4;base64,') == 3
    scores = evaluate("random", "pong", "dopamine", episodes=3)["pong"]
    middle = sorted(range(3), key=lambda number: scores.scores[number])[1]
    assert f"random: {scores.median:,.1f}, game {middle}" in page
    assert "<td>idle:act<td>3<td>-21.0 [-21.0, -21.0]<td>" in page
    assert re.search(r"<h2>Comparison</h2>\n<svg .*<td[^>]*>dopamine/rainbow</td><td>5</td>", page, re.DOTALL)
    assert 'src="http' not in page
    video = tmp_path / "first.mp4"
    video.write_bytes(base64.b64decode(re.search(r'base64,([^"]+)"', page)[1]))
    with av.open(str(video)) as container:
        assert len(container.streams.audio) == 1
        first = next(container.decode(video=0)).to_ndarray(format="rgb24")
    assert (
        np.abs(first[100, 100].astype(int) - [144, 72, 17]).max() < 20
    )  # the brown of the field, not the reset's green


def test_a_page_without_pyav_says_that_it_has_no_videos(capsys, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setitem(sys.modules, "av", None)
    words = ("evaluate", "idle:act", "pong", "--episodes", "1", "--protocol", "dopamine", "-o", "page.html")
    assert main(words) == 0
    assert capsys.readouterr().err.startswith("page.html has no videos: writing a video needs PyAV: ")
    assert "<video" not in (tmp_path / "page.html").read_text()


def test_a_pattern_names_files(capsys, tmp_path):
    torch = pytest.importorskip("torch")

    class Still(torch.nn.Module):
        def forward(self, ram):
            return ram.float() @ torch.zeros(128, 6)

    (tmp_path / "class").mkdir()
    needs = {"environment.json": json.dumps({"obs_type": "ram"})}
    for name in ("grace", "ada"):
        script = torch.jit.trace(Still(), torch.zeros(1, 128, dtype=torch.uint8))
        torch.jit.save(script, str(tmp_path / "class" / f"{name}.pt"), _extra_files=needs)
    words = ("evaluate", "idle:act", "pong", "--beside", "class/*.pt", "--episodes", "1", "--protocol", "dopamine")
    files = [str(Path("class", name)) for name in ("ada.pt", "grace.pt")]
    assert list(json.loads(_json_of(capsys, *words))["results"]) == ["idle:act", *files]
