"""`Task`: what it accepts, what it refuses, and that it is one value."""

import dataclasses
import inspect
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal, get_origin, get_type_hints

import gymnasium
import numpy as np
import pytest
from field_values import CASES, lacking
from hypothesis import HealthCheck, given, settings
from task_strategies import tasks

import atari
from atari.games.actions import Action
from atari.games.catalog import games
from atari.task import PRESETS, Task
from atari.task.arguments import descriptions
from atari.task.description import summary
from atari.task.fields import DEFAULTS, FIELDS, GROUPS, ROWS, TYPES, MakeOptions, TaskOptions, VectorTaskOptions
from atari.task.resolution import ALIASES, OPTIONS
from atari.vector import ale_names

GAMES = ("breakout", "pong", "ms_pacman", "seaquest", "backgammon", "video_checkers")


def test_fields_have_rows_and_cases() -> None:
    assert sorted(FIELDS) == sorted(one.name for one in dataclasses.fields(Task) if one.name != "definition")
    assert sorted(FIELDS) == sorted(name for group in GROUPS.values() for name in group)
    assert {*CASES, "rules", "rom_md5"} == {*FIELDS}
    unchecked = {name: kind for name, kind in TYPES.items() if ROWS[name].check is None}
    assert all(kind is bool or get_origin(kind) is Literal for kind in unchecked.values())


def test_the_docstring_describes_every_field() -> None:
    assert [name for name in descriptions(Task) if name in FIELDS] == list(FIELDS)


@given(tasks(GAMES))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_a_task_is_one_value(task: Task) -> None:
    assert Task.from_json(task.to_json()) == task
    assert eval(repr(task)) == task
    assert pickle.loads(pickle.dumps(task)) == task
    assert hash(Task.of(task)) == hash(task)
    assert Task.of(task) == task
    assert task.differences(Task.from_json(task.to_json())) == {}
    assert task.definition.title in str(task)


@given(tasks(("pong",)), tasks(("pong",)))
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_differences_name_what_differs(one: Task, other: Task) -> None:
    differing = one.differences(other)
    assert (one == other) == (not differing)
    for name, (mine, theirs) in differing.items():
        assert (mine, theirs) == (getattr(one, name), getattr(other, name))


class TestGame:
    @pytest.mark.parametrize("game", ["ms_pacman", "MsPacman", "mspacman", "ALE/MsPacman-v5", "atari:ALE/MsPacman-v5"])
    def test_is_found_by_name_and_id(self, game: str) -> None:
        assert Task.of(game) == Task("ms_pacman")

    def test_is_found_by_file_definition_and_task(self, tmp_path: Path) -> None:
        file = tmp_path / "mine.toml"
        file.write_text(Path(atari.games.__file__).with_name("data").joinpath("pong.toml").read_text())  # type: ignore[attr-defined]
        task = Task.of(file)
        assert task.game == "mine"
        assert Task.of(str(file)) == task == Task.of(task.definition) == Task.of(task)
        assert task != Task("pong")
        assert Task.from_json(task.to_json()) == task
        assert eval(repr(task)) == task

    def test_made_in_memory_is_played(self) -> None:
        own = dataclasses.replace(games["pong"], title="Mine")
        for options in ({}, {"preset": "dqn2015"}):
            assert atari.make(Task.of(own, **options)).unwrapped.task.definition is own

    def test_rules_that_have_changed_are_a_difference(self) -> None:
        text = Task("pong").to_json().replace(Task("pong").rules, "0" * 16)
        assert Task.from_json(text).differences(Task("pong")) == {"rules": ("0" * 16, Task("pong").rules)}

    def test_a_rom_that_is_not_known_is_no_difference(self) -> None:
        known = Task("pong", rom_md5="0" * 32)
        assert known == Task("pong")
        assert known.differences(Task("pong")) == {}
        assert known.differences(Task("pong", rom_md5="1" * 32)) == {"rom_md5": ("0" * 32, "1" * 32)}

    @pytest.mark.parametrize(
        ("game", "error", "text"),
        [
            ("pnog", ValueError, "did you mean 'pong'"),
            ("ALE/Pnog-v5", gymnasium.error.NameNotFound, "did you mean 'ALE/Pong-v5'"),
            ("CartPole-v1", gymnasium.error.NameNotFound, "there is no environment 'CartPole-v1'"),
            (3, TypeError, "a game is named by a string"),
            ("missing.toml", FileNotFoundError, "missing.toml"),
            ("combat", ValueError, "two-player cartridge"),
        ],
    )
    def test_is_refused(self, game: Any, error: type[Exception], text: str) -> None:
        with pytest.raises(error, match=text):
            Task.of(game)


class TestIds:
    @pytest.mark.parametrize(
        ("env_id", "fields"),
        [
            ("ALE/Pong-v5", {}),
            ("ALE/Pong-ram-v5", {"obs_type": "ram"}),
            ("Pong-v0", {"frameskip": (2, 5)}),
            ("PongDeterministic-v4", {"repeat_action_probability": 0.0}),
            ("PongNoFrameskip-v4", {"repeat_action_probability": 0.0, "frameskip": 1}),
            ("Pong-ram-v4", {"repeat_action_probability": 0.0, "frameskip": (2, 5), "obs_type": "ram"}),
        ],
    )
    def test_say_what_is_played(self, env_id: str, fields: dict[str, Any]) -> None:
        assert Task.of(env_id) == Task("pong", **fields)
        assert gymnasium.make(env_id).unwrapped.task == Task.of(env_id)  # type: ignore[attr-defined]


class TestPresets:
    @pytest.mark.parametrize("name", PRESETS)
    def test_decide_over_an_id(self, name: str) -> None:
        assert Task.of("PongNoFrameskip-v0", preset=name) == Task.of("pong", preset=name)
        other = Task.of("PongNoFrameskip-v4", preset=name).differences(Task.of("pong", preset=name))
        decides = "repeat_action_probability" in PRESETS[name].fields
        assert other == ({} if decides else {"repeat_action_probability": (0.0, 0.25)})

    def test_leave_the_ram_of_an_id(self) -> None:
        task = Task.of("Breakout-ram-v4", preset="dqn2015")
        assert (task.obs_type, task.frameskip, task.stack_num, task.noops) == ("ram", 4, None, (1, 30))

    def test_have_stacks_of_images(self) -> None:
        """RAM is stacked only where a user says so, or a task of RAM has a stack."""
        images = Task.of("breakout", preset="envpool")
        for changed in (images.replace(obs_type="ram"), Task.of("breakout", preset="envpool", obs_type="ram")):
            assert (changed.stack_num, changed.padding) == (None, "zero")
        stacks = Task.of("Breakout-ram-v4", preset="envpool", stack_num=2)
        assert (stacks.stack_num, stacks.padding) == (2, "reset")
        assert Task.of(stacks, preset="dqn2015").stack_num == stacks.replace(noops=(0, 3)).stack_num == 2
        assert "a stack of 2, which begins with copies of the first RAM" in str(stacks)

    def test_give_way_to_options(self) -> None:
        task = Task.of("breakout", preset="dqn2015", frameskip=3, episodic_life=False)
        assert (task.frameskip, task.episodic_life, task.on_reset) == (3, False, "new_game")

    @pytest.mark.parametrize(
        ("options", "text"),
        [
            ({"repeat_action_probability": 0.25}, "needs repeat_action_probability=0.0, got 0.25"),
            ({"full_action_space": True}, "needs full_action_space=False, got True"),
            ({"actions": ["NOOP", "UP"]}, "needs actions='minimal', got"),
            ({"players": 2}, "is for one player"),
        ],
    )
    def test_refuse_what_they_require(self, options: dict[str, Any], text: str) -> None:
        with pytest.raises(ValueError, match=text):
            Task.of("pong", preset="dqn2015", **options)

    def test_accept_agents_that_have_some_of_the_actions(self) -> None:
        whole = Task.of("pong", preset="dqn2015")
        some = Task.of("pong", preset="dqn2015", actions=["LEFT", "NOOP"])
        assert whole.differences(some) == {"actions": ("minimal", ("LEFT", "NOOP"))}
        assert some.begin_actions == whole.begin_actions == whole.action_set
        assert len(Task.of("pong", preset="envpool", actions=["UP"]).begin_actions) == 18

    def test_accept_the_same_actions_by_another_name(self) -> None:
        assert Task.of("boxing", preset="dqn2015", full_action_space=True) == Task.of("boxing", preset="dqn2015")


class TestOptions:
    def test_have_other_names(self) -> None:
        assert Task.of("breakout", full_action_space=True, clip_reward=True) == Task(
            "breakout", actions="full", reward_clipping=True
        )

    def test_come_in_any_order(self) -> None:
        options = {"noops": (1, 30), "fire": "after_noops", "fire_counts": True, "frameskip": 2}
        assert Task.of("pong", **options) == Task.of("pong", **dict(reversed(options.items())))

    @pytest.mark.parametrize("name", OPTIONS)
    def test_of_another_kind_are_refused(self, name: str) -> None:
        with pytest.raises((TypeError, ValueError), match=name.split("_")[0]):
            Task.of("pong", **{name: object()})

    @pytest.mark.parametrize(
        ("options", "text"),
        [
            ({"frame_skip": 4}, "did you mean 'frameskip'"),
            ({"sticky_actions": 0.25}, "did you mean 'repeat_action_probability'"),
            ({"full_action_space": True, "actions": "full"}, "two names of one option"),
            ({"clip_reward": True, "reward_clipping": True}, "two names of one option"),
        ],
    )
    def test_that_do_not_exist_are_refused(self, options: dict[str, Any], text: str) -> None:
        with pytest.raises(TypeError, match=text):
            Task.of("pong", **options)


def test_probabilities_by_player_are_of_several_players() -> None:
    with pytest.raises(TypeError, match="repeat_action_probability must be a number within"):
        Task.of("pong", repeat_action_probability=[0.25])
    assert Task.of("combat", players=2, repeat_action_probability=[0.25, 0.25]).repeat_action_probability == 0.25


WITHOUT_EFFECT: list[tuple[dict[str, Any], dict[str, Any]]] = [
    *(({name: case.value}, dict(case.needs)) for name, case in CASES.items() if case.needs and name != "players"),
    ({"last_life": True}, {"life_loss_info": True}),
    ({"max_frames": 300, "max_num_frames_per_episode": 200}, {"max_num_frames_per_episode": None}),
    ({"obs_type": "ram", "maxpool": True}, {"obs_type": "dict"}),
    ({"obs_type": "ram", "padding": "reset"}, {"stack_num": 4}),
]

CONTRADICTIONS: list[tuple[dict[str, Any], dict[str, Any]]] = [
    ({"fire": "before_noops", "fire_unit": "skip"}, {"fire": "after_noops"}),
    ({"third_action": True, "fire": "after_noops", "continuous": True}, {"continuous": False}),
    ({"episodic_life": True, "life_loss_info": True}, {"episodic_life": False}),
    ({"seamless_lives": True, "episodic_life": True, "lives_unit": "skip"}, {"lives_unit": "frame"}),
    ({"pool_rgb": True, "maxpool": True, "obs_type": "grayscale", "end_frames": "envpool"}, {"end_frames": "last"}),
    ({"img_height": 230, "img_width": 84}, {"img_height": 210}),
    ({"img_height": 84}, {"img_width": 84}),
    ({"sound_obs": True, "obs_type": "dict"}, {"obs_type": "rgb"}),
    ({"players": 2, "episodic_life": True}, {"episodic_life": False}),
    ({"players": 2, "fire": "after_noops"}, {"fire": "never"}),
    ({"actions": ("NOOP",), "continuous": True}, {"continuous": False}),
]


@pytest.mark.parametrize(("wrong", "change"), [*WITHOUT_EFFECT, *CONTRADICTIONS])
def test_combinations_without_a_meaning_are_refused_and_have_a_neighbour(
    wrong: dict[str, Any], change: dict[str, Any]
) -> None:
    with pytest.raises(ValueError, match="|".join(wrong)):
        Task("pong", **wrong)
    Task(**{"game": "pong", **wrong, **change})


@pytest.mark.parametrize("name", [name for name in CASES if name not in ("game", *lacking("one"))])
def test_the_printed_task_has_every_field(name: str) -> None:
    case = CASES[name]
    others = {"game": "breakout", **case.needs, **case.seen}
    one, other = (str(Task(**fields)).splitlines()[1:] for fields in (others, {**others, name: case.value}))
    assert one != other


def test_the_first_line_names_interventions() -> None:
    task = Task.of("pong", interventions=["lazy_enemy", "slow_enemy"])
    assert summary(task) == "pong: Pong, as ALE/Pong-v5, but interventions=['lazy_enemy', 'slow_enemy']"
    assert Task.of("pong", interventions=["lazy_enemy", "slow_enemy"]) == task  # the words can be given again


def test_fields_without_effect_of_another_task_are_left_out() -> None:
    task = Task.of("breakout", preset="envpool", episodic_life=True)
    assert task.seamless_lives
    assert not task.replace(episodic_life=False).seamless_lives
    assert task.replace(fire="never").fire_counts is False


@pytest.mark.parametrize(
    ("options", "begins"),
    [
        ({}, True),
        ({"seamless_lives": True}, True),  # a reset begins a new game
        ({"seamless_lives": True, "on_reset": "continue"}, False),
        ({"seamless_lives": True, "on_reset": "noop"}, False),
        ({"seamless_lives": False, "on_reset": "continue"}, True),
        ({"episodic_life": False, "life_loss_info": True}, False),  # a report ends nothing
    ],
)
def test_lost_lives_that_begin_a_new_stack(options: dict[str, Any], begins: bool) -> None:
    assert Task.of("breakout", **{"episodic_life": True, **options}).new_stack_after_life is begins


def test_an_action_is_named_once() -> None:
    with pytest.raises(ValueError, match="actions has a name twice: NOOP, FIRE, NOOP"):
        Task.of("pong", actions=["NOOP", "FIRE", "NOOP"])


def test_the_third_action_needs_three() -> None:
    game = dataclasses.replace(games.find("freeway"), minimal_actions=(Action.NOOP, Action.FIRE))
    with pytest.raises(ValueError, match="freeway has only 2; use actions='full'"):
        Task(game, fire="after_noops", third_action=True)  # type: ignore[arg-type]
    assert Task("breakout", actions=("NOOP",), fire="after_noops", third_action=True).third_action


@pytest.mark.parametrize("name", [name for name in DEFAULTS if isinstance(DEFAULTS[name], bool)])
@pytest.mark.parametrize("value", ["no", 1, None])
def test_switches_are_true_or_false(name: str, value: Any) -> None:
    with pytest.raises(TypeError, match=name):
        Task("pong", **{name: value})


def test_messages_have_the_number_that_was_given() -> None:
    """A threshold is compared as float32, which has no 0.1."""
    with pytest.raises(ValueError, match=r"continuous_action_threshold=0\.1 has no effect"):
        Task.of("pong", continuous_action_threshold=0.1)
    task = Task.of("pong", continuous=True, continuous_action_threshold=float(np.float32(0.1)))
    assert task == Task.of("pong", continuous=True, continuous_action_threshold=0.1)
    assert "threshold 0.1\n" in str(task)


class TestTypedOptions:
    """Editors and type checkers know the options by `TaskOptions` and the classes made of it."""

    def test_are_the_options_of_a_task(self) -> None:
        assert set(get_type_hints(TaskOptions)) == {*OPTIONS, *ALIASES}
        assert set(get_type_hints(VectorTaskOptions)) == {*OPTIONS, *ALIASES, *ale_names.NAMES}
        assert set(get_type_hints(MakeOptions)) - set(get_type_hints(TaskOptions)) == {
            "render_mode",
            "core",
            "rom",
            "disable_env_checker",
        }

    def test_are_written_from_the_rows(self) -> None:
        script = Path(__file__).parents[2] / "scripts" / "generate" / "options.py"
        subprocess.run([sys.executable, script, "--check"], check=True)

    @pytest.mark.parametrize(
        "function", [Task.of, Task.replace, atari.make, atari.AtariEnv.__init__, atari.AtariVectorEnv.__init__]
    )
    def test_are_those_of_each_door(self, function: Any) -> None:
        assert "Unpack" in str(inspect.signature(function).parameters["options"].annotation)
