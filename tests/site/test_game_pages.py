import sys
from itertools import pairwise
from pathlib import Path

import gymnasium
import pytest

import atari
from atari.games.interventions import load
from atari.recording import Replay

SITE = Path(__file__).parents[2] / "scripts" / "site"


@pytest.fixture(scope="module")
def pages():
    """By path, the text of all pages of games, without media."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SITE))
        from gamepages import index, text

        made = {game.id: text.page(game, frozenset()) for game in atari.games.values()}
        made["index"] = index.page(list(atari.games.values()), ())
        yield made
        for name in [name for name in sys.modules if name.partition(".")[0] == "gamepages"]:
            del sys.modules[name]


def test_every_game_has_a_page_with_its_sections(pages):
    assert set(pages) == {*atari.games, "index"}
    for game in atari.games.values():
        page = pages[game.id]
        heads = [line[3:] for line in page.splitlines() if line.startswith("## ")]
        assert heads[:5] == ["Make it", "Rules", "Actions", "Modes", "Difficulties"], game.id
        assert ("Scores" in heads) == game.single_player
        assert ("RAM" in heads) == bool(game.ram_labels)
        changes = load(game)
        assert ("Interventions" in heads) == bool(changes)
        assert all(f"<tr><td><code>{one.name}</code></td><td>" in page for one in changes.values()), game.id
        assert ">None<" not in page, game.id


def test_the_index_links_to_every_page_and_has_what_its_filters_read(pages):
    for game in atari.games.values():
        assert f'href="{game.id}.html"' in pages["index"]
    assert pages["index"].count("data-lives=") == len(atari.games)
    assert (
        'data-name="breakout breakout atari" data-actions="4" data-lives="5" data-players="1" '
        f'data-labels="{len(atari.games["breakout"].ram_labels)}" data-sticky="2"' in pages["index"]
    )


def test_facts_of_a_game_of_one_player(pages):
    page = pages["ms_pacman"]
    for text in (
        "1983 · Atari · 1 player",
        'gymnasium.make("ALE/MsPacman-v5")',
        'gymnasium.make("MsPacman-ramNoFrameskip-v4")',
        'envpool.make_gymnasium("MsPacman-v5"',
        "<td>5</td><td><code>UPRIGHT</code></td><td>6</td><td>↑ + →</td>",
        "<td>0 (default)</td><td>the standard game</td>",
        "<td>human</td><td>6,951.6</td>",
        "At the start `info` has 3.",
        "<code>player_x</code>",
        'atari.make("ms_pacman", interventions=["frightened_ghosts"])',
        "<td><code>frozen_ghosts</code></td><td>The ghosts stand still.</td>",
    ):
        assert text in page, text


def test_a_family_of_names_is_one_row(pages):
    assert (
        "<td>0 to 35</td><td><code>0x80</code> to <code>0xA3</code></td><td><code>block_bits_0</code>, "
        "<code>block_bits_1</code>, ... <code>block_bits_35</code></td><td>other</td><td>one bit a brick, 1 = standing; 6 "
        "groups (columns) of 6 rows. changes in play (6), never changed (30)</td>" in pages["breakout"]
    )
    assert "<td>117 to 108</td>" in pages["freeway"]
    assert "always in row 27, 43, ... 171" in pages["freeway"]
    assert "<td>98, 100, ... 104</td>" in pages["qbert"]  # with gaps in RAM
    assert pages["asteroids"].count("<code>asteroid_") == 5 * 3  # of two objects, seven and eight of each


def test_every_label_is_in_one_family(pages):
    from gamepages import families

    for game in atari.games.values():
        found = families.families(game.ram_labels.values(), lambda label: label.note or "")
        assert sorted(label.name for family in found for label in family) == sorted(game.ram_labels)
        for family in found:
            assert len({label.kind for label in family}) == 1
            assert len({b.index - a.index for a, b in pairwise(family)}) <= 1
            assert len(family) != 2


def test_lives_that_are_counted_after_the_reset_are_explained(pages):
    for game, text in (
        (
            "amidar",
            "Four, counted as 11, 10, 9 and 8, which is how ALE reads the byte of the cartridge. At the reset `info` has 0, and half a second later 11.",
        ),
        ("turmoil", "At the reset `info` has 3, and half a second later 4."),
    ):
        assert text in pages[game]
        core = atari.cores.NativeCore(game, repeat_action_probability=0.0)
        core.reset()
        assert f"At the reset `info` has {core.lives}," in text
    assert "At the reset" not in pages["breakout"]


def test_a_cartridge_for_two_says_so(pages):
    page = pages["combat"]
    assert "no game of one player" in page
    assert "tanks, open field" in page
    assert "atari play combat --players 2" in page
    assert "gymnasium.make" not in page


def test_the_ids_exist(pages):
    for line in pages["pong"].splitlines():
        if "gymnasium.make(" in line:
            assert line.split('"')[1] in gymnasium.registry


def test_media_are_linked_where_the_build_has_them(pages):
    from gamepages import facts, index, text

    game = atari.games["pong"]
    page = text.page(game, frozenset({facts.VIDEO, facts.SCREEN, facts.MODES, facts.VIEWS}))
    assert page.count("pong/play.mp4") == 1
    assert "muted loop playsinline" in page
    assert page.count("url(pong/modes.png)") == len(game.modes)
    assert page.count("url(pong/views.png)") == len(atari.PRESETS)
    assert index.page([game], ["pong"]).count("<img") == 1


def test_the_observations_of_a_dark_game_are_of_a_bright_moment(pages):
    pytest.importorskip("av")
    from gamepages import media, plays

    rows = media._views(Replay.load(plays.play_of("gravitar").path)).reshape(len(atari.PRESETS), 84, -1)
    assert (rows > 30).mean(axis=(1, 2)).min() > 0.3


@pytest.mark.parametrize(
    ("built", "media", "address"),
    [
        (True, {"play.film"}, "../play/index.html#show=pong"),
        (True, set(), "../play/index.html#game=pong"),
        (False, {}, ""),
    ],
)
def test_the_game_plays_on_its_page(pages, monkeypatch, built, media, address):
    import player
    from gamepages import text

    monkeypatch.setattr(player, "is_built", lambda: built)
    page = text.page(atari.games["pong"], frozenset(media))
    assert page.count(f'<iframe src="{address}"') == built
