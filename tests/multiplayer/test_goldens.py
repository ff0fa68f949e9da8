"""All environments give what PettingZoo's give, as digests that `cases.py` has stored."""

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pettingzoo")
from multiplayer.cases import cases, digest

from atari.multiplayer import parallel_env

GOLDENS = json.loads(Path(__file__).with_name("goldens.json").read_text(encoding="utf-8"))
CASES = [(number, name, arguments) for number, (name, arguments) in enumerate(cases())]


def test_every_way_to_make_an_environment_has_a_golden() -> None:
    assert [f"{name} {json.dumps(arguments)}" for _, name, arguments in CASES] == list(GOLDENS)
    assert len({name for _, name, _ in CASES}) == 24


@pytest.mark.parametrize(("number", "name", "arguments"), CASES, ids=lambda value: value if type(value) is str else "")
def test_a_game_gives_what_pettingzoo_gives(number: int, name: str, arguments: dict[str, Any]) -> None:
    assert digest(parallel_env(name, **arguments), number + 1) == GOLDENS[f"{name} {json.dumps(arguments)}"]
