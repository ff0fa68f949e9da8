"""AtariARI's names and categories."""

import pytest

import atari
from atari.lab import atari_ari


def test_the_places_are_those_of_the_game_files():
    for game, names in atari_ari.INDICES.items():
        known = {label.index for label in atari.games[game].ram_labels.values() if "AtariARI" in label.sources}
        # The game files leave out a byte that is not what its name says.
        assert set(names.values()) - known <= ({64} if game == "berzerk" else set()), game


def test_lists_are_numbered():
    names = atari_ari.indices(atari.games["qbert"])
    assert [names[f"score_{number}"] for number in range(3)] == [89, 90, 91]
    assert "score" not in names
    assert names["tile_color_20"] == 42


@pytest.mark.parametrize(
    ("name", "categories"),
    [
        ("player_x", ["agent_localization"]),
        ("player_column", ["agent_localization"]),
        ("ball_y", ["small_object_localization"]),
        ("player_missile_x1", ["small_object_localization"]),
        ("enemy_skull_x", ["other_localization"]),
        ("clock_ms", ["score_clock_lives_display"]),
        ("oxygen_meter_value", ["score_clock_lives_display"]),
        ("frame_number_display", ["score_clock_lives_display"]),
        ("num_lives_direction", ["score_clock_lives_display", "misc_keys"]),
        ("room_number", ["misc_keys"]),
        ("pin_existence_3", ["misc_keys"]),
        ("tile_color_0", []),
    ],
)
def test_categories(name, categories):
    assert list(atari_ari.categories(name)) == categories
    assert set(categories) <= set(atari_ari.CATEGORIES)
