"""The interventions in the package: each has the effect that its check states, and docs/interventions.md lists them all."""

from pathlib import Path

import pytest

from atari.games.catalog import games
from atari.lab.interventions import check, load

INTERVENTIONS = [(game, name) for game in games for name in load(game)]
DOCS = Path(__file__).parents[2] / "docs" / "interventions.md"


@pytest.mark.parametrize(("game", "name"), INTERVENTIONS)
def test_an_intervention_has_its_effect(game: str, name: str) -> None:
    result = check(game, name)
    assert result, result
    assert result.picture > 0.005, result


def test_the_package_has_many_interventions() -> None:
    assert len(INTERVENTIONS) >= 60
    assert len({game for game, _ in INTERVENTIONS}) >= 25


def rows() -> list[str]:
    """The rows of the table in the documentation: a game and its interventions, but for the one that many games have."""
    lines: dict[str, str] = {}
    for game, name in INTERVENTIONS:
        intervention = load(game)[name]
        assert intervention.check, f"{game}: {name} has no check"
        if name != "infinite_lives":
            title = games[game].title
            lines[title] = f"{lines.get(title, f'| {title} |')} `{name}`: {intervention.description}"
    return [f"{line} |" for line in lines.values()]


def test_the_documentation_lists_all() -> None:
    text = DOCS.read_text("utf-8")
    table = [line for line in text.splitlines() if line.startswith("|")]
    assert table[2:] == rows()
    lives = ", ".join(games[game].title for game, name in INTERVENTIONS if name == "infinite_lives")
    assert f"These games have it: {lives}." in " ".join(text.split())
