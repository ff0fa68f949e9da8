"""Variants of a task: the axes, the tasks, their names, and their evaluation with equal seeds."""

from dataclasses import replace

import pytest

from atari.games.catalog import games
from atari.lab.interventions import load
from atari.learning import PROTOCOLS, Result, compare, evaluate
from atari.learning.evaluation.variants import DELAYS, find_axes, variants_of
from atari.task import Task

SHORT = replace(PROTOCOLS["dopamine"], name="short", max_frames=400, epsilon=0.0)


def moving(observations):
    """Actions that depend on every pixel."""
    return observations.reshape(len(observations), -1).sum(1, dtype="int64") % 3


@pytest.mark.parametrize(
    ("variants", "axes"),
    [
        ("modes", (("modes",),)),
        ("modes, delays", (("modes",), ("delays",))),
        (["modes*difficulties", "modes"], (("modes", "difficulties"), ("modes",))),
    ],
)
def test_axes(variants, axes):
    assert find_axes(variants) == axes


@pytest.mark.parametrize(
    ("error", "variants", "text"),
    [
        (
            ValueError,
            "mode",
            "an axis of variants must be one of 'modes', 'difficulties', 'interventions', 'delays', got 'mode'",
        ),
        (ValueError, "modes,", "got ''"),
        (ValueError, "modes,modes", "names 'modes' twice"),
        (ValueError, "modes*modes", "or an axis twice in it"),
        (ValueError, "modes*delays,delays*modes", "names 'delays\\*modes' twice"),
        (TypeError, 3, "variants must be axes"),
        (TypeError, [], "variants must be axes"),
        (TypeError, [("modes",)], "variants must be axes"),
    ],
)
def test_wrong_axes(error, variants, text):
    with pytest.raises(error, match=text):
        find_axes(variants)


def test_one_axis_at_a_time():
    task, game = Task.of("freeway"), games["freeway"]
    found = variants_of(task, find_axes("modes,difficulties,interventions,delays"))
    assert found[0] == task
    assert len({*found}) == len(found)
    assert all(len(task.differences(one)) == 1 for one in found[1:])
    changed = [next(iter(task.differences(one))) for one in found[1:]]
    assert changed.count("mode") == len(game.modes) - 1
    assert changed.count("difficulty") == len(game.difficulties) - 1
    assert changed.count("interventions") == len(load("freeway"))
    assert changed.count("action_delay") == changed.count("observation_delay") == len(DELAYS)


def test_a_product_has_all_combinations_once():
    task, game = Task.of("freeway", mode=3), games["freeway"]
    found = variants_of(task, find_axes("difficulties,modes*difficulties"))
    assert {(one.mode, one.difficulty) for one in found} == {(m, d) for m in game.modes for d in game.difficulties}
    assert len(found) == len(game.modes) * len(game.difficulties)


def test_interventions_are_added_to_those_of_the_task():
    task = Task.of("pong", interventions=["lazy_enemy"])
    found = variants_of(task, find_axes("interventions"))
    assert all(one.interventions[0].name == "lazy_enemy" for one in found)
    assert {len(one.interventions) for one in found[1:]} == {2}
    assert len(found) == len(load("pong"))


def test_a_game_without_variants_is_refused():
    with pytest.raises(ValueError, match="carnival has no variants by modes; choose other axes of modes, difficulties"):
        variants_of(Task.of("carnival"), find_axes("modes"))


def test_each_variant_is_the_evaluation_of_its_task_with_equal_seeds(capsys):
    axes = "modes,difficulties,interventions,delays"
    result = evaluate(moving, "pong", SHORT, variants=axes, episodes=2, seed=5)
    named = result.variants()
    assert capsys.readouterr().err == f"{len(named)} tasks, 2 games of each: {2 * len(named)} games\n"
    assert next(iter(named)) == "as given"
    assert {one.seeds for one in named.values()} == {result["pong"].seeds}
    for name, options in {
        "as given": {},
        "mode=1": {"mode": 1},
        "difficulty=1": {"difficulty": 1},
        "intervention=lazy_enemy": {"interventions": ["lazy_enemy"]},
        "action_delay=6": {"action_delay": 6},
        "observation_delay=12": {"observation_delay": 12},
    }.items():
        alone = evaluate(moving, Task.of("pong", **options), SHORT, episodes=2, seed=5)
        assert alone["pong"] == named[name], name
    assert named["mode=1"].changes == {"mode": 1}


def test_a_policy_of_another_mode_plays_the_default_as_a_variant():
    moving_in_1 = type(
        "Moving", (), {"task": Task.of("pong", mode=1, preset="dopamine"), "__call__": lambda self, o: moving(o)}
    )
    result = evaluate(moving_in_1(), Task.of("pong", mode=1), SHORT, variants="modes", episodes=1)
    assert list(result.variants()) == ["as given", "mode=0"]


def test_files_texts_and_figures(tmp_path):
    result = evaluate("noop", ["freeway", "pong"], SHORT, variants="difficulties", episodes=2, progress=lambda *_: None)
    result.save(tmp_path / "result.json")
    assert Result.load(tmp_path / "result.json") == result
    assert list(result.variants("pong")) == ["as given", "difficulty=1", "difficulty=2", "difficulty=3"]
    with pytest.raises(ValueError, match="results of several games; name one of freeway, pong"):
        result.variants()
    text = str(result)
    assert [line.split()[0] for line in text.splitlines() if line.startswith("difficulty=1 ")] == ["difficulty=1"] * 2
    assert "games of each: 2; short has 100" in text
    with pytest.raises(ValueError, match="the result of noop has variants, which it compares itself"):
        compare(result)
    pytest.importorskip("matplotlib")
    result.plot(tmp_path / "figure.svg")
    assert "pong: mean score" in (tmp_path / "figure.svg").read_text()


def test_workers_and_parts_change_no_score():
    class Here:
        def map(self, function, tasks):
            return map(function, tasks)

    options = {"variants": "difficulties", "episodes": 3, "progress": lambda *_: None}
    assert evaluate("noop", "freeway", SHORT, workers=Here(), parts=2, **options) == evaluate(
        "noop", "freeway", SHORT, **options
    )
