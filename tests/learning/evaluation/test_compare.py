"""`compare`: normalised scores, intervals, and the comparisons that it refuses."""

import json
import sys
from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from atari.learning import GAME_SETS, PROTOCOLS, Published, Result, compare
from atari.learning.evaluation.results import GameResult
from atari.learning.evaluation.statistics import estimate_of_episodes, estimate_of_runs, interquartile_mean, profile


def result(protocol="dopamine", frames=None, shift=0.0, games=("breakout", "pong")):
    played = []
    for game in games:
        scores = tuple(float(score) + shift for score in range(10, 20))
        played.append(GameResult(game, scores, (1000,) * 10, (False,) * 10, tuple(range(10))))
    return Result("mine", PROTOCOLS[protocol], 0, tuple(played), frames)


def test_scores_and_summaries():
    comparison = compare(result(), "dopamine/rainbow")
    mine, rainbow = comparison.rows
    references = (Published.human_scores()[game] for game in ("breakout", "pong"))
    breakout, pong = ((14.5 - random) / (human - random) for random, human in references)
    assert mine.median.value == mine.mean.value == mine.iqm.value == pytest.approx((breakout + pong) / 2)
    assert mine.median.low < mine.median.value < mine.median.high
    assert comparison.normalised(mine)["pong"] == pytest.approx(pong)
    assert (mine.runs, rainbow.runs, rainbow.frames) == (1, 5, 199_000_000)
    assert rainbow.scores["pong"] == tuple(Published("dopamine/rainbow").final("pong"))
    assert not comparison.mixed
    assert compare(result(), "dopamine/rainbow") == comparison


def test_several_trainings_are_runs():
    runs = [result(shift=shift) for shift in (0.0, 1.0, 2.0)]
    row = compare(runs, "dopamine/rainbow").rows[0]
    assert row.runs == 3
    assert row.scores["pong"] == (14.5, 15.5, 16.5)
    merged = compare([result(games=["pong"]), result(games=["breakout"])], "dopamine/rainbow")
    assert merged.games == compare(result(), "dopamine/rainbow").games
    assert merged.rows[0].runs == 1


def test_policies_with_different_names_are_different_agents():
    mine, other = result(), replace(result(shift=1.0, games=("pong", "breakout", "seaquest")), policy="other")
    comparison = compare([mine, other, mine], "dopamine/rainbow")
    assert [(row.name, row.runs) for row in comparison.rows] == [("mine", 2), ("other", 1), ("dopamine/rainbow", 5)]
    assert comparison.games == ("breakout", "pong")
    assert comparison.rows[1].scores["pong"] == (15.5,)
    assert "other: " in "\n".join(comparison.notes)
    alone = compare([replace(other, games=other.games[:2]), mine], to=())
    assert alone.rows == (comparison.rows[1], compare(mine, to=()).rows[0])


def test_a_mapping_names_the_agents():
    trainings = [replace(result(shift=shift), policy=f"runs/{shift}") for shift in (0.0, 1.0)]
    comparison = compare({"mine": trainings, "other": result()}, to=())
    assert [(row.name, row.runs, row.scores["pong"]) for row in comparison.rows] == [
        ("mine", 2, (14.5, 15.5)),
        ("other", 1, (14.5,)),
    ]
    assert len(compare(trainings, to=()).rows) == 2


@pytest.mark.parametrize(
    ("changes", "text"),
    [({}, ""), ({"mode": 4}, "mode"), ({"difficulty": 1}, "difficulty"), ({"interventions": [{}]}, "interventions")],
)
def test_games_of_another_mode_or_with_interventions_are_not_compared(changes, text):
    played, task = result(games=["breakout"]), {"mode": 0, "difficulty": 0, "interventions": [], **changes}
    played = replace(played, games=(replace(played["breakout"], task=task),))
    if not changes:
        assert not compare(played, "dopamine/rainbow").mixed
        return
    with pytest.raises(ValueError, match=f"breakout is played with another {text}"):
        compare(played, "dopamine/rainbow")
    assert f"another {text}" in compare(played, "dopamine/rainbow", mixed=True).notes[0]


def test_budgets_that_differ_by_one_percent_are_one():
    results = {"a": result(frames=199_000_064), "b": result(frames=200_015_872)}
    comparison = compare(results, "dopamine/rainbow")
    assert (comparison.mixed, [row.frames for row in comparison.rows]) == (False, [199_000_064] * 3)
    assert not compare(results["b"], "dopamine/rainbow").mixed
    with pytest.raises(ValueError, match="different numbers of frames: 199,000,064 and 202,000,000"):
        compare({**results, "b": result(frames=202_000_000)}, "dopamine/rainbow")


def test_equal_frames():
    comparison = compare(result(frames=10_000_000), ["dopamine/rainbow", "dopamine/dqn"])
    assert [row.frames for row in comparison.rows] == [10_000_000] * 3
    assert comparison.rows[1].scores["pong"] == tuple(Published("dopamine/rainbow").at("pong", 10_000_000))
    at_mean = compare(result(), "dopamine/rainbow", frames=30_000_000).rows[1]
    assert (at_mean.runs, at_mean.iqm.low) == (None, None)  # the source has only the mean over seeds there
    between, at = (str(compare(result(), "dopamine/rainbow", frames=frames)) for frames in (30_500_000, 30_000_000))
    assert "rainbow at 30,500,000 frames: the mean of its games of frames 30,000,001 to 31,000,000" in between
    assert "the mean of its games" not in at


@pytest.mark.parametrize(
    ("to", "frames", "at"),
    [
        ("dopamine/rainbow", 4096, 1_000_000),
        ("dreamerv3/ppo", 4096, 1_000_000),
        ("dreamerv3/ppo", 3_000_000, 2_500_000),
        ("dopamine/rainbow", 300_000_000, 199_000_000),
        ("cleanrl/ppo", 4096, 40_000_000),
    ],
)
def test_another_budget_is_marked_and_not_renamed(to, frames, at):
    comparison = compare(result(frames=frames), to, mixed=True)
    mine, other = comparison.rows
    assert comparison.mixed
    assert (mine.frames, other.frames) == (frames, at)
    agent = Published(to)
    expected = agent.final("pong") if at == agent.final_frames else agent.at("pong", at)
    assert other.scores["pong"] == tuple(expected)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"to": "cleanrl/ppo"}, "repeat_action_probability is 0.0, and 0.25 in dopamine"),
        ({"to": "cleanrl/ppo"}, "lives is fire, and continue in dopamine; protocol 'baselines' has its environments"),
        ({"to": ["dopamine/rainbow", "dreamerv3/ppo"]}, "full_action_space is True"),
        ({"to": "dopamine_nets/rainbow_cnn"}, "max_frames is 100000"),
        ({"results": result("machado2018")}, "full_action_space is False, and True in machado2018"),
        ({"results": result(frames=201_000_000)}, "until 199,000,000 frames"),
        ({"results": result(frames=262_144)}, "rainbow are at 1,000,000 frames, not at 262,144: its curve begins with"),
        ({"results": result("baselines", 10_000_000), "to": "cleanrl/ppo"}, "only at 40,000,000 frames"),
        ({"results": [result(), result("machado2018")]}, "results are of protocols dopamine and machado2018"),
        ({"results": [result(frames=4), result(frames=8)]}, "different numbers of frames: 4 and 8"),
        ({"results": result(frames=4_000_000), "frames": 8_000_000}, "trained for 4,000,000 frames"),
        ({"human": "nature2015"}, "the human table nature2015 is not for scores of dopamine"),
        ({"human": "human_starts"}, "use noop57"),
    ],
)
def test_refuses_to_mix_unless_told(arguments, text):
    arguments = {"results": result(), "to": "dopamine/rainbow", **arguments}
    with pytest.raises(ValueError, match="mixed=True") as caught:
        compare(**arguments)
    assert text in str(caught.value)
    comparison = compare(**arguments, mixed=True)
    assert comparison.mixed
    assert str(comparison).startswith("MIXED PROTOCOLS OR BUDGETS")
    assert any(text in note for note in comparison.notes)


def test_what_is_comparable():
    for name, to in [
        ("dqn2015", "pfrl/dqn"),
        ("dqn2015", "papers/dqn2015"),
        ("baselines", "cleanrl/ppo"),
        ("baselines", "sb3_zoo/ppo"),
        ("dopamine_nets", "dopamine_nets/rainbow_cnn"),
        ("noop_starts", "papers/rainbow"),
        ("dreamerv3", "dreamerv3/ppo"),
        ("atari100k_noops", "dreamerv3/atari100k/dreamerv3"),
        ("machado2018", "cleanba/cleanba_ppo_8gpu"),  # one no-op is no random start
    ]:
        assert not compare(result(name), to).mixed
    assert not compare(result("dqn2015"), "papers/dqn2015", human="nature2015").mixed


@pytest.mark.parametrize(
    ("error", "arguments", "text"),
    [
        (TypeError, {"results": 3}, "results must be"),
        (TypeError, {"results": []}, "results must be"),
        (ValueError, {"to": "dopamine/dqnn"}, "dopamine/dqn"),
        (ValueError, {"human": "noop56"}, "noop57"),
        (ValueError, {"repetitions": 0}, "repetitions"),
        (ValueError, {"frames": 0}, "frames"),
        (ValueError, {"results": result(games=["adventure"])}, "there is no game"),
        (
            ValueError,
            {"results": [result(games=["pong"]), replace(result(games=["breakout"]), policy="other")], "to": ()},
            "no game that all of mine, other, noop57 have scores of",
        ),
        (TypeError, {"to": result()}, "a Result is none; results are compared with each other in a list, as compare(["),
        (TypeError, {"to": ["dopamine/rainbow", result()]}, "a Result is none"),
    ],
)
def test_wrong_arguments(error, arguments, text):
    with pytest.raises(error) as caught:
        compare(**{"results": result(), "to": "dopamine/rainbow", **arguments})
    assert text in str(caught.value)


def test_games_that_not_all_have_are_left_out():
    comparison = compare(result(games=["pong", "adventure"]), "dopamine/rainbow")
    assert comparison.games == ("pong",)
    assert any("left out" in note and "adventure" in note for note in comparison.notes)


def test_the_estimate_of_atari_5():
    """The estimate, computed by hand from the coefficients of the paper's code. Rainbow has 1.19, and a median of 1.48."""
    comparison = compare(result(games=GAME_SETS["atari5"]), "dopamine/rainbow")
    weights = {
        "battle_zone": 0.3819751237831753,
        "double_dunk": 0.0679099488887574,
        "name_this_game": 0.310804148620847,
        "phoenix": 0.12412619402774641,
        "qbert": 0.08048518286466755,
    }
    rainbow = {game: runs.mean() for game, runs in comparison.normalised(comparison.rows[1]).items()}
    expected = 10 ** sum(weight * np.log10(1 + 100 * max(0, rainbow[game])) for game, weight in weights.items()) - 1
    assert f"dopamine/rainbow {expected / 100:.3f}" in comparison.notes[-1]
    assert 1.0 < expected / 100 < 1.8


def test_files_and_text(tmp_path):
    comparison = compare(result(), ["dopamine/rainbow"])
    comparison.save(tmp_path / "comparison.json")
    content = json.loads((tmp_path / "comparison.json").read_text())
    assert (content["rows"][0]["name"], content["human"]) == ("mine", "noop57")
    assert "dopamine/rainbow     5  199,000,000" in str(comparison)
    assert "google/dopamine, Apache-2.0" in str(comparison)
    assert repr(comparison) == "Comparison(mine, dopamine/rainbow, 2 games)"
    page = comparison._repr_html_()
    assert page.startswith("<p><strong>human-normalised scores (table noop57), games: 2</strong></p>")
    assert page.count("<table>") == 2
    assert '<td style="text-align:left">dopamine/rainbow</td><td>5</td><td>199,000,000</td>' in page
    assert "16,256.9" in str(compare(result(games=["video_pinball"]), "dopamine/rainbow"))


def test_iqm_is_the_trimmed_mean():
    for count in range(1, 12):
        values = np.random.default_rng(count).normal(size=count)
        cut = int(0.25 * count)
        assert interquartile_mean(values) == pytest.approx(np.sort(values)[cut : count - cut].mean())


def test_intervals_cover():
    """About 95 % of the intervals of 200 samples contain the mean of the distribution."""
    generator = np.random.default_rng(0)
    inside = 0
    for number in range(200):
        scores = {str(game): generator.normal(1.0, 1.0, 30) for game in range(4)}
        mean = estimate_of_runs(scores, 300, number)["mean"]
        inside += mean.low <= 1.0 <= mean.high
    assert 180 <= inside <= 199


def test_intervals_of_episodes_are_those_of_runs_for_the_mean():
    scores = {game: np.random.default_rng(0).normal(size=50) for game in "ab"}
    runs, episodes = estimate_of_runs(scores, 4000, 0)["mean"], estimate_of_episodes(scores, 4000, 0)["mean"]
    assert episodes.value == pytest.approx(runs.value)
    assert episodes.low == pytest.approx(runs.low, abs=0.02)
    assert episodes.high == pytest.approx(runs.high, abs=0.02)


def test_without_two_of_anything_there_is_no_interval():
    one = {"pong": np.ones(1)}
    assert str(estimate_of_runs(one, 10, 0)["iqm"]) == str(estimate_of_episodes(one, 10, 0)["mean"]) == "1.000"


def test_profile():
    scores = {"a": np.array([0.0, 1.0]), "b": np.array([2.0])}
    assert profile(scores, np.array([-1.0, 0.0, 0.5, 1.0, 2.0])).tolist() == [1.0, 0.75, 0.75, 0.5, 0.0]


def test_no_matplotlib(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.delitem(sys.modules, "atari.learning.evaluation.plot", raising=False)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'torch>=2\.2'"):
        compare(result()).plot(tmp_path / "a.svg")
