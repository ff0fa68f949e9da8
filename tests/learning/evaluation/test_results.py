"""`Result`: statistics, the table, files, and damaged files."""

import json
from dataclasses import replace

import pytest

from atari.base import json_text
from atari.learning import PROTOCOLS, Result
from atari.learning.evaluation.results import GameResult


def result():
    pong = GameResult("pong", (-21.0, 3.5, 21.0), (4000, 9000, 6000), (False, True, False), (5, 6, 7), {"stack_num": 4})
    breakout = GameResult("breakout", (1.0,), (600,), (False,), (8,))
    return Result("mine", PROTOCOLS["dopamine"], 3, (pong, breakout), 40_000_000, {"numpy": "2"})


def test_statistics():
    pong = result()["pong"]
    assert (pong.mean, pong.median, pong.truncations) == (3.5 / 3, 3.5, 1)
    assert pong.std == pytest.approx(17.226, abs=1e-3)
    with pytest.raises(KeyError, match="there are some of pong, breakout"):
        result()["qbert"]


def test_the_table():
    assert str(result()) == (
        "policy mine, seed 3\n"
        "protocol dopamine: sticky actions 0.25, the game's minimal actions, no no-ops, 4 frames an action, epsilon 0.001, "
        "at most 108,000 frames a game; unclipped scores of whole games\n"
        "\n"
        "game      games  mean   std  median    min   max  truncated\n"
        "pong          3   1.2  17.2     3.5  -21.0  21.0          1\n"
        "breakout      1   1.0   0.0     1.0    1.0   1.0          0\n"
        "\n"
        "games of each: 3 or 1; dopamine has 100\n"
        "1 of 4 games did not end within 108,000 frames"
    )


def test_what_a_notebook_and_a_debugger_show():
    assert repr(result()) == "Result('mine', pong, breakout, protocol 'dopamine', seed 3)"
    assert repr(result()["pong"]) == "GameResult('pong', 3 games, mean 1.2)"
    many = replace(result(), games=tuple(GameResult(name, (1.0,), (4,), (False,), (0,)) for name in "abcd"))
    assert repr(many) == "Result('mine', a, b, 2 more, protocol 'dopamine', seed 3)"
    page = replace(result(), policy="<script>")._repr_html_()
    assert page.startswith("<p><strong>policy &lt;script&gt;, seed 3</strong></p><p>protocol dopamine: sticky actions")
    assert page.count("<table>") == 1
    assert '<td style="text-align:left">pong</td><td>3</td><td>1.2</td>' in page
    assert page.endswith("<p>1 of 4 games did not end within 108,000 frames</p>")


def test_the_table_names_what_differs_from_the_games_own():
    intervention = {"name": "lazy_enemy", "description": "-", "source": "-", "writes": []}
    task = {"mode": 1, "difficulty": 0, "interventions": [intervention], "frameskip": 3}
    usual = {"mode": 0, "difficulty": 0, "interventions": []}
    pong, breakout = result().games
    changed = replace(result(), games=(replace(pong, task=task), replace(breakout, task=usual)))
    assert "\npong was played with mode=1, frameskip=3, interventions=['lazy_enemy']\n" in str(changed)
    assert "breakout was played" not in str(changed)
    own = replace(pong, game="own", task={**usual, "difficulty": 1})
    assert "own was played with mode=0, difficulty=1" in str(replace(result(), games=(own,)))
    assert "interventions=7" in str(replace(result(), games=(replace(pong, task={"interventions": 7}),)))


def test_a_file_keeps_everything(tmp_path):
    file = tmp_path / "result.json"
    result().save(file)
    assert Result.load(file) == result()
    assert json.loads(file.read_text())["versions"] == {"numpy": "2"}


def test_a_flipped_bit_of_any_byte_is_found(tmp_path):
    file = tmp_path / "result.json"
    result().save(file)
    data = file.read_bytes()
    refused = 0
    for place in range(len(data)):
        flipped = bytearray(data)
        flipped[place] ^= 1 << place % 8
        file.write_bytes(flipped)
        try:
            assert Result.load(file) == result()  # another space between words of JSON
        except ValueError:
            refused += 1
    assert refused > 7 / 8 * len(data)


def changed(**changes):
    return {**json.loads(json.dumps(result().to_json())), **changes}


def without(name):
    content = changed()
    del content[name]
    return content


def with_protocol(**changes):
    return changed(protocol={**changed()["protocol"], **changes})


def with_game(**changes):
    content = changed()
    content["games"][0].update(changes)
    return content


@pytest.mark.parametrize(
    ("content", "text"),
    {
        "no JSON": ("{", "is no result"),
        "foreign": ({"games": []}, "format"),
        "another version": (changed(format="atari evaluation 4"), "of another release"),
        "a task of another kind": (with_game(task=[]), "'task' must be a table"),
        "no protocol's task": (with_protocol(task={"game": "pong"}), '"format" must be'),
        "no seed": (without("seed"), "needs the key 'seed'"),
        "no protocol": (without("protocol"), "needs the key 'protocol'"),
        "no games": (changed(games=[]), "at least one"),
        "a game twice": (changed(games=changed()["games"][:1] * 2), "once, and at least one"),
        "a game is no object": (changed(games=[1]), "a game must be a table, got 1"),
        "other numbers": (with_protocol(epsilon=0.5), "needs another name"),
        "unknown number": (with_protocol(luck=1), "luck"),
        "bool as a seed": (changed(seed=True), "'seed' must be a whole number, got True"),
        "a score missing": (with_game(scores=[1.0]), "as many scores"),
        "a score of text": (with_game(scores=["1", 2, 3]), "each of scores must be a number, got '1'"),
        "a score that is none": (with_game(scores=[float("nan"), 2, 3]), "no number"),
        "a huge score": (with_game(scores=[10**400, 2, 3]), "is out of range"),
        "no scores": (with_game(scores=3), "'scores' must be a list"),
        "frames of text": (with_game(frames="abc"), "'frames' must be a list"),
        "truncated is a number": (with_game(truncated=[0, 0, 0]), "each of truncated must be true or false, got 0"),
    }.values(),
)
def test_damaged_files(tmp_path, content, text):
    file = tmp_path / "result.json"
    file.write_text(json.dumps(json_text.seal(content)) if isinstance(content, dict) else content)
    with pytest.raises(ValueError, match="result") as caught:
        Result.load(file)
    assert text in str(caught.value)
    assert str(file) in str(caught.value)


def test_missing_files(tmp_path):
    with pytest.raises(FileNotFoundError):
        Result.load(tmp_path / "result.json")
    with pytest.raises(IsADirectoryError):
        Result.load(tmp_path)
