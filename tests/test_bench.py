"""`scripts/bench.py` runs and prints correct ratios. No test asserts a speed."""

import json
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import ale_py
import pytest
from env_tools import needs_gymnasium_1, needs_new_ale_py

pytestmark = [needs_gymnasium_1, needs_new_ale_py]
SCRIPT = Path(__file__).parent.parent / "scripts" / "bench.py"


@pytest.fixture(scope="module")
def bench() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


@pytest.mark.parametrize(
    ("suite", "games", "comparisons"),
    [
        ("raw", ["pong", "breakout"], 2),
        ("state", ["pong"], 5),
        ("env", ["pong"], 1),
        ("preset", ["pong"], 1),
        ("vector", ["pong"], 7),
        ("sizes", ["pong"], 2),
    ],
)
def test_a_suite_runs_and_writes_every_measured_value(
    suite: str,
    games: list[str],
    comparisons: int,
    bench: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def few(game: str, count: int, **options: Any) -> Any:
        return theirs(game, min(count, 2), **options)

    theirs, out = ale_py.AtariVectorEnv, tmp_path / "out.json"
    monkeypatch.setattr(ale_py, "AtariVectorEnv", few)  # ale-py loads a cartridge for each environment
    options = ["--suite", suite, "--games", *games, "--steps", "20", "--rounds", "2", "--json", str(out)]
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), *options, "--envs", "1", "2"])
    bench["main"]()
    assert capsys.readouterr().out.count(f"over {len(games)} games, minimum") >= comparisons
    document = json.loads(out.read_text())
    assert (document["suite"], document["steps"], document["rounds"]) == (suite, 20, 2)
    assert document["machine"]["cores"] >= 1
    assert document["versions"]["ale-py"]
    assert list(document["results"]) == games
    for times in document["results"].values():
        assert len(times) == comparisons
        for contestants in times.values():
            assert len(contestants) >= 2
            assert all(len(values) == 2 and min(values) > 0 for values in contestants.values())


def test_ratios_are_of_medians(bench: dict[str, Any]) -> None:
    results = {"pong": {"native": [1.0, 2.0, 9.0], "ale-py": [30.0, 20.0, 1.0]}}
    assert bench["ratios"](results, "native", "ale-py") == {"pong": 10.0}


def test_a_few_ratios_come_to_a_mean_and_a_minimum(bench: dict[str, Any]) -> None:
    assert bench["summary"]({"pong": 4.0, "tetris": 1.0}) == [
        "geometric mean 2.00x over 2 games, minimum 1.00x (tetris)"
    ]


def test_many_ratios_come_to_quartiles_and_the_ten_worst_too(bench: dict[str, Any]) -> None:
    _, quartiles, worst = bench["summary"]({f"game{i}": float(i) for i in range(13, 0, -1)})
    assert quartiles == "quartiles 4.00x, 7.00x, 10.00x"
    assert worst == "ten worst " + ", ".join(f"game{i} {i}.00x" for i in range(1, 11))


def test_the_table_has_a_row_a_game(bench: dict[str, Any]) -> None:
    results = {"pong": {"native": [2.0], "ale-py": [3.0]}, "tetris": {"native": [5.0], "ale-py": [5.0]}}
    lines = bench["table"]("act", results).splitlines()
    assert lines[1].split() == ["native", "ale-py"]
    assert lines[2].split() == ["pong", "2.0", "(", "1.50x)", "3.0", "(", "1.00x)"]
    assert lines[3].split() == ["tetris", "5.0", "(", "1.00x)", "5.0", "(", "1.00x)"]
    assert lines[4] == "native: geometric mean 1.22x over 2 games, minimum 1.00x (tetris)"
    assert lines[5] == "spread of the rounds: 0% of the median (typically)"


def test_ratios_to_envpool_are_printed_too(bench: dict[str, Any]) -> None:
    results = {"pong": {"native": [2.0], "EnvPool": [8.0], "ale-py": [6.0]}}
    lines = bench["table"]("step", results).splitlines()
    assert lines[3:6] == [
        "native: geometric mean 3.00x over 1 games, minimum 3.00x (pong)",
        "EnvPool: geometric mean 0.75x over 1 games, minimum 0.75x (pong)",
        "native beside EnvPool: geometric mean 4.00x over 1 games, minimum 4.00x (pong)",
    ]


def test_envpool_is_left_out_where_it_lacks_a_game(
    bench: dict[str, Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "envpool", SimpleNamespace(list_all_envs=lambda: ["Pong-v5"]))
    sides = [(name, None) for name in ("native", "EnvPool", "ale-py")]
    comparisons = [bench["Comparison"]("step", sides)]
    assert bench["without_envpool"](comparisons, ["pong"]) == comparisons
    (comparison,) = bench["without_envpool"](comparisons, ["pong", "tic_tac_toe_3d"])
    assert [name for name, _ in comparison.contestants] == ["native", "ale-py"]
    assert capsys.readouterr().err == "EnvPool lacks tic_tac_toe_3d and is left out.\n"


def test_an_unknown_game_is_an_error_before_anything_is_measured(
    bench: dict[str, Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), "--games", "pong", "pnog"])
    with pytest.raises(ValueError, match="pong"):
        bench["main"]()
    assert capsys.readouterr().err == ""
