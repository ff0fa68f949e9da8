"""Every ID in the history of these environments. That each makes an environment is in `conformance/test_ids.py`."""

import copy
import json
import os
import re
import subprocess
import sys
from collections import Counter
from typing import Any

import gymnasium
import pytest

import atari
from atari.env import AtariEnv
from atari.registry import registration
from atari.registry.making import make_AtariVectorEnv
from atari.registry.registration import ALGORITHMIC
from atari.task import env_ids


def ours() -> dict[str, Any]:
    return {
        env_id: spec
        for env_id, spec in gymnasium.registry.items()
        if spec.entry_point == "atari.registry.making:make_AtariEnv"
    }


@pytest.fixture(scope="module")
def theirs() -> dict[str, dict[str, Any]]:
    """The IDs that ale-py registers without this package."""
    program = (
        "import json, gymnasium, ale_py\n"
        "fields = ('kwargs', 'max_episode_steps', 'reward_threshold', 'nondeterministic', 'order_enforce',\n"
        "          'disable_env_checker', 'additional_wrappers')\n"
        "specs = {i: s for i, s in gymnasium.registry.items() if str(s.entry_point).startswith('ale_py')}\n"
        "print(json.dumps({i: {f: getattr(s, f) for f in fields} for i, s in specs.items()}))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    specs: dict[str, dict[str, Any]] = json.loads(result.stdout)
    if not specs:
        pytest.skip("this ale-py leaves the registration of its IDs to Gymnasium's plug-ins")
    return specs


def test_there_are_952_ids() -> None:
    assert len(ours()) == len(env_ids.ids()) == 952
    assert set(ours()) == set(env_ids.ids())


def test_each_family_has_its_number() -> None:
    count = Counter(
        re.sub(r"^(ALE/)?[A-Za-z0-9]+?((-ram)?(Deterministic|NoFrameskip)?-v\d)$", r"\1X\2", i) for i in ours()
    )
    legacy = {
        f"X{ram}{speed}-v{version}": 62
        for ram in ("", "-ram")
        for speed in ("", "Deterministic", "NoFrameskip")
        for version in (0, 4)
    }
    assert dict(count) == {**legacy, "ALE/X-v5": 104, "ALE/X-ram-v5": 104}
    assert sum(legacy.values()) == 744


def test_62_games_have_legacy_ids() -> None:
    assert len(set(env_ids.LEGACY_GAMES)) == 62
    assert set(env_ids.LEGACY_GAMES) <= {game.id for game in atari.games.playable()}


@pytest.mark.parametrize(
    ("game", "stem"),
    [
        ("pong", "Pong"),
        ("ms_pacman", "MsPacman"),
        ("up_n_down", "UpNDown"),
        ("jamesbond", "Jamesbond"),
        ("tic_tac_toe_3d", "TicTacToe3D"),
        ("atlantis2", "Atlantis2"),
    ],
)
def test_the_stem_of_a_game(game: str, stem: str) -> None:
    assert env_ids.stem(game) == stem
    assert f"ALE/{stem}-v5" in gymnasium.registry


@pytest.mark.parametrize(
    ("env_id", "options"),
    [
        ("Breakout-v0", {"frameskip": (2, 5), "repeat_action_probability": 0.25}),
        ("Breakout-v4", {"frameskip": (2, 5), "repeat_action_probability": 0.0}),
        ("BreakoutDeterministic-v0", {"frameskip": 4, "repeat_action_probability": 0.25}),
        ("BreakoutDeterministic-v4", {"frameskip": 4, "repeat_action_probability": 0.0}),
        ("BreakoutNoFrameskip-v0", {"frameskip": 1, "repeat_action_probability": 0.25}),
        ("BreakoutNoFrameskip-v4", {"frameskip": 1, "repeat_action_probability": 0.0}),
        ("Breakout-ram-v0", {"frameskip": (2, 5), "repeat_action_probability": 0.25, "obs_type": "ram"}),
        ("Breakout-ramDeterministic-v4", {"frameskip": 4, "repeat_action_probability": 0.0, "obs_type": "ram"}),
        ("Breakout-ramNoFrameskip-v0", {"frameskip": 1, "repeat_action_probability": 0.25, "obs_type": "ram"}),
        ("ALE/Breakout-v5", {"frameskip": 4, "repeat_action_probability": 0.25}),
        ("ALE/Breakout-ram-v5", {"frameskip": 4, "repeat_action_probability": 0.25, "obs_type": "ram"}),
    ],
)
def test_an_id_stands_for_options(env_id: str, options: dict[str, Any]) -> None:
    common = {"game": "breakout", "full_action_space": False, "max_num_frames_per_episode": 108_000}
    spec = gymnasium.spec(env_id)
    assert spec.kwargs == {**common, **options, "base": spec.id}
    assert (spec.max_episode_steps, spec.reward_threshold, spec.nondeterministic) == (None, None, False)


@pytest.mark.parametrize(
    "suffix", ["Deterministic-v0", "Deterministic-v4", "-ramDeterministic-v0", "-ramDeterministic-v4"]
)
def test_space_invaders_skips_three_frames(suffix: str) -> None:
    """With four frames, its blinking shots would be invisible."""
    assert gymnasium.spec(f"SpaceInvaders{suffix}").kwargs["frameskip"] == 3
    assert gymnasium.spec(f"Pong{suffix}").kwargs["frameskip"] == 4


def test_where_ale_py_has_the_same_id_the_spec_is_the_same(theirs: dict[str, dict[str, Any]]) -> None:
    assert len(theirs) == 352
    assert set(theirs) <= set(ours())
    for env_id, fields in theirs.items():
        spec = ours()[env_id]
        mine = {field: copy.deepcopy(getattr(spec, field)) for field in fields}
        assert mine["kwargs"].pop("base") == env_id  # beside ale-py's options, for presets
        assert json.loads(json.dumps(mine)) == fields, env_id


def test_the_600_others_are_ours_alone(theirs: dict[str, dict[str, Any]]) -> None:
    others = set(ours()) - set(theirs)
    assert len(others) == 600
    assert all("-ram" in env_id or "Deterministic" in env_id for env_id in others)


# make()


@pytest.mark.parametrize("name", ["breakout", "ALE/Breakout-v5", "Breakout-ram-v4", "BreakoutNoFrameskip-v4"])
def test_make_takes_a_game_or_an_id(name: str) -> None:
    env = atari.make(name)
    assert isinstance(env.unwrapped, AtariEnv)
    assert env.unwrapped.game.id == "breakout"
    assert env.spec is not None
    assert env.spec.id == (name if "-v" in name else "ALE/Breakout-v5")


def test_make_takes_the_options_of_the_environment_and_of_gymnasium() -> None:
    env = atari.make("breakout", obs_type="ram", frameskip=1, max_episode_steps=3)
    assert env.reset(seed=0)[0].shape == (128,)
    assert [env.step(0)[3] for _ in range(3)] == [False, False, True]
    assert env.unwrapped.core.frame_number == 3  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("wrong", "cure"),
    [
        ("Breakout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("breakout-v4", "did you mean 'Breakout-v4'?"),
        ("ALE/breakout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("ale/Breakout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("ALE/Breakout-v4", "did you mean 'Breakout-v4' or 'ALE/Breakout-v5'?"),
        ("ALE/Breakout-ram-v4", "did you mean 'Breakout-ram-v4' or 'ALE/Breakout-ram-v5'?"),
        ("Breakout-ram-v5", "did you mean 'ALE/Breakout-ram-v5'?"),
        ("BreakoutNoFrameskip-v3", "did you mean 'BreakoutNoFrameskip-v0' or 'BreakoutNoFrameskip-v4'?"),
        ("Breakout-NoFrameskip-v4", "did you mean 'BreakoutNoFrameskip-v4'?"),
        ("BreakoutDeterministic-v5", "did you mean 'BreakoutDeterministic-v0' or 'BreakoutDeterministic-v4'?"),
        ("Ms_Pacman-v4", "did you mean 'MsPacman-v4'?"),
        ("ALE/Breakout", "did you mean 'ALE/Breakout-v5'?"),
        ("ALE/Brekout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("Brekout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("Brekout-v4", "did you mean 'Breakout-v4'?"),
        ("atari:Breakout-v5", "did you mean 'ALE/Breakout-v5'?"),
        ("atari:ALE/Breakout-v4", "did you mean 'Breakout-v4'?"),
        ("Copi-v0", "did you mean 'Copy-v0'?"),
        ("copy-v0", "did you mean 'Copy-v0'?"),
        ("Revers-v0", "did you mean 'Reverse-v0'?"),
        ("ReversedAddition3-v1", "did you mean 'ReversedAddition3-v0'?"),
        ("ALE/RepeatCopy", "did you mean 'RepeatCopy-v0'?"),
        ("CartPole-v1", "see `atari info --ids` for all of them"),
    ],
)
def test_the_error_for_a_wrong_id_suggests_the_right_one(wrong: str, cure: str) -> None:
    for lookup in (atari.make, atari.explain):
        with pytest.raises(gymnasium.error.NameNotFound) as error:
            lookup(wrong)
        assert str(error.value) == f"there is no environment {wrong!r}; {cure}"


def test_every_id_registered_by_this_package_is_one_that_make_takes() -> None:
    known = registration.known_ids()
    assert set(known) >= {*env_ids.ids(), *ALGORITHMIC}
    assert all(
        type(atari.make(env_id).unwrapped).__module__.startswith("atari.") for env_id in [*known[::100], *ALGORITHMIC]
    )
    assert "CartPole-v1" not in known


# explain()


def test_only_what_has_a_history_is_explained() -> None:
    text = "only IDs of ALE's games are explained, 'Copy-v0' is none; gymnasium.spec('Copy-v0') shows what it is"
    with pytest.raises(gymnasium.error.NameNotFound, match=re.escape(text)):
        atari.explain("Copy-v0")


def test_explain_says_what_an_id_means() -> None:
    assert atari.explain("SpaceInvadersDeterministic-v4").splitlines()[:11] == [
        "SpaceInvadersDeterministic-v4: Space Invaders",
        "  observation   RGB screen (210, 160, 3), uint8",
        "  frame skip    3 frames a step",
        "  sticky        no",
        "  actions       6, those the game uses: NOOP FIRE RIGHT LEFT RIGHTFIRE LEFTFIRE",
        "  begin         the emulator's reset alone",
        "  lives         a lost life does not end an episode",
        "  limit         truncated after 108,000 frames of the emulator",
        "  reward        the change of the score",
        "  mode          0 of 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15; difficulty 0 of 0, 1",
        "  siblings",
    ]


def test_explain_says_how_the_siblings_differ() -> None:
    siblings = dict(
        re.split(r"\s{2,}", line.strip(), maxsplit=1)
        for line in atari.explain("PongDeterministic-v4").partition("siblings\n")[2].splitlines()
    )
    assert len(siblings) == 13
    assert siblings["PongDeterministic-v0"] == "sticky actions"
    assert siblings["ALE/Pong-v5"] == "sticky actions"
    assert siblings["Pong-ramDeterministic-v4"] == "RAM"
    assert siblings["PongNoFrameskip-v4"].startswith("frame skip: ")
    assert "PongDeterministic-v4" not in siblings
    assert "ALE/Pong-v5               the same" in atari.explain("PongDeterministic-v0")


def test_every_family_and_every_game_can_be_explained() -> None:
    """Most games have the IDs of one speed here: each text lists the others."""
    some = ("pong", "space_invaders", "backgammon", "tetris")
    for env_id, (family, game) in env_ids.ids().items():
        if game not in some and "-v5" not in env_id:
            continue
        text = atari.explain(env_id)
        assert text.startswith(f"{env_id}: {atari.games[game].title}\n")
        assert ("128 bytes of RAM" in text) == (family.ram)


# ATARI_REGISTER


def registered(imports: str, choice: str | None) -> subprocess.CompletedProcess[str]:
    """Print the entry points of an ID that ale-py has too, of one that it lacks, and the class that `make` makes."""
    program = (
        f"{imports}\nimport gymnasium\n"
        "print(*(str(gymnasium.spec(i).entry_point).split('.')[0] for i in ('ALE/Pong-v5', 'PongDeterministic-v4')),\n"
        "      type(atari.make('pong').unwrapped).__module__,\n"
        "      type(atari.make('ALE/Pong-v5', preset='dqn2015').unwrapped).__module__)"
    )
    env = {key: value for key, value in os.environ.items() if key != "ATARI_REGISTER"}
    if choice is not None:
        env["ATARI_REGISTER"] = choice
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env, check=False)


@pytest.mark.parametrize(
    ("imports", "choice"),
    [("import ale_py, atari", None), ("import atari, ale_py", "all")],
)
def test_ale_pys_ids_are_replaced(imports: str, choice: str | None) -> None:
    assert registered(imports, choice).stdout == "atari atari atari.env.env atari.env.env\n"


@pytest.mark.parametrize("imports", ["import atari, ale_py", "import ale_py, atari"])
def test_own_keeps_ale_pys_ids_and_make_still_makes_ours(imports: str, theirs: dict[str, dict[str, Any]]) -> None:
    assert registered(imports, "own").stdout == "ale_py atari atari.env.env atari.env.env\n"


def test_another_value_is_refused() -> None:
    result = registered("import atari", "none")
    assert result.returncode != 0
    assert "ATARI_REGISTER must be 'all' (replace ale-py's IDs) or 'own' (keep them), got 'none'" in result.stderr


@pytest.mark.parametrize("env_id", ["atari:ALE/Pong-v5", "atari:Pong-v4"])
def test_the_prefix_of_the_module_is_taken(env_id: str) -> None:
    assert atari.make(env_id).unwrapped.game.id == "pong"
    assert gymnasium.make(env_id).unwrapped.game.id == "pong"
    assert atari.explain(env_id).startswith(f"{env_id}: Pong")


@pytest.mark.parametrize("make", [gymnasium.make, lambda env_id, **options: make_AtariVectorEnv(env_id, 1, **options)])
def test_a_value_that_equals_the_ids_is_checked_too(make: Any) -> None:
    for env_id, skip in (("ALE/Pong-v5", 4.0), ("PongNoFrameskip-v4", True)):
        with pytest.raises(gymnasium.error.Error, match=r"frameskip must be an integer within 1\.\.10000, got"):
            make(env_id, frameskip=skip)
    make("ALE/Pong-v5", frameskip=4, repeat_action_probability=0.25, full_action_space=False).close()
