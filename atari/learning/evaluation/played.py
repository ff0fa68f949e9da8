"""The task that an evaluation plays, from a game, a protocol and a policy. `resolve_games` is its door for games."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

from atari.base.frozen import FrozenDict
from atari.games.game import Game
from atari.learning.evaluation.protocols import GAME_SETS, PROTOCOLS, EvaluationProtocol, find_protocol, in_words
from atari.policy.needs import in_game, needs_of, task_with_fields
from atari.task import PRESETS, Task
from atari.task.fields import GROUPS, OF_GAME
from atari.task.task import GameLike, look_up


@dataclass(frozen=True)
class EvaluatedGame:
    """A game of an evaluation, and how the user named it: an ID and a `Task` say more than the name of a game.

    Attributes:
        task: a task whose game and fields `OF_GAME` are played.
        env_id: the environment ID, if the user gave one.
        is_task: whether the user gave a `Task`, all of whose fields must then be played.
    """

    task: Task
    env_id: str | None = None
    is_task: bool = False

    @property
    def id(self) -> str:
        """The game's id."""
        return self.task.game

    @property
    def ram(self) -> bool:
        """Whether the user gave an ID or a `Task` of RAM."""
        return not self.task.kind.image

    @classmethod
    def of_policy(cls, task: Task, options: Mapping[str, Any] = FrozenDict()) -> "EvaluatedGame":
        """The game of a policy's task: its game and its fields `OF_GAME` alone, or what options say instead."""
        return cls(Task.of(task.definition, **{**_of_game(task), **options}))


def resolve_games(
    games: "GameLike | EvaluatedGame | Sequence[GameLike | EvaluatedGame]", options: Mapping[str, Any] = FrozenDict()
) -> tuple[EvaluatedGame, ...]:
    """The games of an argument: a game, an ID, a `Task`, a name of `GAME_SETS`, or a sequence of these; each game once.

    Args:
        games: the argument. An `EvaluatedGame` is not changed.
        options: options of `Task.of` for all games.

    Raises:
        TypeError, ValueError: a game is not known (the nearest is suggested), no game is given, or a game is given
            twice with other modes, difficulties or interventions.
        gymnasium.error.NameNotFound: an ID is not known.
        FileNotFoundError: the file of a game of your own does not exist.
    """
    listed = [games] if isinstance(games, (str, PathLike, Game, Task, EvaluatedGame)) else games
    if not isinstance(listed, Sequence) or not listed:
        raise TypeError(f"games must be a game, a set such as 'atari26', or a sequence of these, got {games!r}")
    found: dict[str, tuple[EvaluatedGame, Any]] = {}
    for given in listed:
        for one in GAME_SETS.get(given, (given,)) if isinstance(given, str) else (given,):
            if isinstance(one, EvaluatedGame):
                game = one
            else:
                named = look_up(one)
                game = EvaluatedGame(named.task(None, options), named.env_id, isinstance(named.game, Task))
            other, first = found.setdefault(game.id, (game, one))
            if (other.task, other.env_id) != (game.task, game.env_id):
                raise ValueError(f"{game.id} is given twice, as {first!r} and {one!r}; leave one of them out")
    return tuple(game for game, _ in found.values())


def usual_protocol(policy: Any, game: EvaluatedGame) -> EvaluationProtocol:
    """The protocol that commands play unless a user names one.

    It is the protocol of the policy's training, else the whole games of the policy's `task`. A policy without `task`,
    `environment` and `protocol` plays the whole games of an ID or a `Task`. For all others it is "baselines".
    """
    own, task = getattr(policy, "protocol", None), getattr(policy, "task", None)
    if own is not None:
        return find_protocol(own)
    if isinstance(task, Task):
        return _of_whole_games(in_game(task, game.task).replace(**_of_game(game.task)), "task")
    if has_no_needs(policy) and (game.env_id is not None or game.is_task):
        return _of_whole_games(game.task, game.env_id or "task")
    return PROTOCOLS["baselines"]


def _of_whole_games(task: Task, name: str) -> EvaluationProtocol:
    return EvaluationProtocol.of_task(task, name=name, source=f"whole games of {name}", epsilon=0.0, episodes=1)


def has_no_needs(policy: Any) -> bool:
    """Whether a policy has no attribute that says which environments it needs."""
    return not any(getattr(policy, name, None) for name in ("task", "environment", "protocol"))


def played_task(game: EvaluatedGame, protocol: EvaluationProtocol, policy: Any) -> Task:
    """The task that an evaluation plays.

    The game decides the fields `OF_GAME`. The protocol decides the actions, sticky actions, frame skip,
    how games begin, lives and limits. The policy decides the observations; without `task` and `environment` it sees RAM
    if the game is an ID or a `Task` of RAM, else the images of the protocol's preset or task.

    Raises:
        ValueError: game, protocol and policy contradict each other, the policy's options are wrong, or the game is a
            `Task` with another field that is not played; the message says what to pass.
    """
    own = needs_of(policy, game.task.definition).task
    _check_alone(game.task, game.id)
    if own is not None:
        _check_policy(game.task, protocol, own)
    _check_id(game, protocol, own)
    seen = own or (game.task if game.ram else None)
    if protocol.task is not None:
        if game.id != protocol.task.game:
            text = f"the protocol is of {protocol.task.game}, and the game is {game.id}"
            raise ValueError(f"{text}; pass {protocol.task.game!r} as the game")
        _check_alike(game.task, protocol.task, "protocol", OF_GAME)
        played = _whole_games(protocol, protocol.task, seen)
    else:
        fields = {**_observation(seen, protocol.preset), **_play(protocol), **_lives(protocol)}
        played = task_with_fields(game.task, **fields, **_of_game(game.task))
    if game.is_task and game.task != protocol.task:
        _check_given(game.task, played, protocol)
    return played


def _of_game(task: Task) -> dict[str, Any]:
    return {name: getattr(task, name) for name in OF_GAME}


def _observation(seen: Task | None, preset: str) -> dict[str, Any]:
    fields = PRESETS[preset].fields if seen is None else {name: getattr(seen, name) for name in GROUPS["observation"]}
    return {name: fields[name] for name in GROUPS["observation"] if name in fields and name not in OF_GAME}


def _play(protocol: EvaluationProtocol) -> dict[str, Any]:
    return {
        "repeat_action_probability": protocol.repeat_action_probability,
        "actions": "full" if protocol.full_action_space else "minimal",
        "frameskip": protocol.frame_skip,
        "noops": (protocol.noop_min, protocol.noop_max),
        "max_num_frames_per_episode": protocol.max_frames,
    }


def _lives(protocol: EvaluationProtocol) -> dict[str, Any]:
    """The fields that decide how games begin besides the no-ops, and how they go on after a lost life."""
    if protocol.lives == "continue":
        return {}
    preset = PRESETS["baselines" if protocol.lives == "fire" else protocol.preset].fields
    names = [name for name in (*GROUPS["begin"], *GROUPS["lives"]) if name != "noops" and name in preset]
    # Whole games are played, and the stack begins anew after a lost life, as in trainings whose episodes are lives.
    after = "continue" if preset["on_reset"] == "new_game" else preset["on_reset"]
    own = {name: preset[name] for name in names}
    return {**own, "episodic_life": True, "on_reset": after, "seamless_lives": False}


def _whole_games(protocol: EvaluationProtocol, task: Task, seen: Task | None) -> Task:
    """The whole games of a task, with scores that are not clipped."""
    names = [name for group in ("play", "begin", "lives", "limits") for name in GROUPS[group]]
    own = {name: getattr(task, name) for name in names}
    own["life_loss_info"] = False  # a report that ends nothing
    if own["on_reset"] == "new_game":
        own["on_reset"] = "continue"
    if all(own[name] is None for name in GROUPS["limits"]):
        own["max_num_frames_per_episode"] = protocol.max_frames  # a game may never end by itself
    return task_with_fields(task, **{**own, **_observation(seen or task, ""), **_of_game(task)})


def _check_alone(task: Task, owner: str) -> None:
    for name, value in (("players", 1), ("continuous", False)):
        if getattr(task, name) != value:
            raise ValueError(
                f"an evaluation plays games with {name}={value}, and {owner} has {name}={getattr(task, name)}; "
                "leave it out"
            )


def _check_policy(game: Task, protocol: EvaluationProtocol, policy: Task) -> None:
    """Refuse a policy of another game than the one that is played, unless the user asks for this other game."""
    _check_alone(policy, "the policy")
    said, default = game.as_options(), Task.of(game.definition).as_options()
    _check_alike(game, policy, "policy", [name for name in OF_GAME if said[name] == default[name]])
    if policy.frames != protocol.frames:
        ours, theirs = in_words(protocol.frames), in_words(policy.frames)
        raise ValueError(f"protocol {protocol.name!r} plays {ours} frames an action, the policy {theirs}")


def _check_id(game: EvaluatedGame, protocol: EvaluationProtocol, policy: Task | None) -> None:
    named = game.ram or game.env_id is not None
    if named and policy is not None and (not policy.kind.image) != game.ram:
        shown, name = "RAM" if game.ram else "images", game.env_id or f"the task of {game.id}"
        raise ValueError(f"{name} shows {shown}, and the policy sees obs_type={policy.obs_type!r}; pass {game.id!r}")
    sticky = game.task.repeat_action_probability
    if game.env_id is not None and sticky != protocol.repeat_action_probability:
        raise ValueError(
            f"{game.env_id} has repeat_action_probability={sticky}, and protocol {protocol.name!r} "
            f"{protocol.repeat_action_probability}; pass {game.id!r}, or another protocol"
        )


def _check_given(task: Task, played: Task, protocol: EvaluationProtocol) -> None:
    """Refuse a task with fields that are not played. Fields with the values of ALE's v5 are not compared."""
    given = Task.of(task.game if task.definition.file is None else task.definition).differences(task)
    decided = (*GROUPS["game"], *GROUPS["reward"], *OF_GAME)
    pairs = {name: pair for name, pair in task.differences(played).items() if name in given and name not in decided}
    if pairs:
        ours = ", ".join(f"{name}={value!r}" for name, (value, _) in pairs.items())
        theirs = ", ".join(f"{name}={value!r}" for name, (_, value) in pairs.items())
        raise ValueError(
            f"the task of {task.game} has {ours}, and protocol {protocol.name!r} with this policy plays {theirs}; "
            f"pass {task.game!r}, or EvaluationProtocol.of_task(task, ...) as the protocol"
        )


def _check_alike(game: Task, wanted: Task, owner: str, names: Iterable[str]) -> None:
    for name in names:
        if wanted.as_options()[name] != game.as_options()[name]:
            theirs, ours = _shown(wanted, name), _shown(game, name)
            raise ValueError(
                f"the {owner} plays {wanted.game} with {name}={theirs}, and the game to evaluate has {ours}; "
                f"pass atari.Task.of({game.game!r}, {name}={theirs}) as the game, or give a command "
                f"{_flags(wanted, name)}"
            )


def _flags(task: Task, name: str) -> str:
    value, flag = task.as_options()[name], f"--{name.removesuffix('s').replace('_', '-')}"
    values = [one.name for one in task.interventions] if name == "interventions" else [value]
    texts = [",".join(map(str, one)) if isinstance(one, tuple) else one for one in values]
    return " ".join(f"{flag} {text}" for text in texts) if value else f"no {flag}"


def _shown(task: Task, name: str) -> str:
    """The text of a field in an error, as a user gives it: None is the default mode or difficulty."""
    value = [one.name for one in task.interventions] if name == "interventions" else task.as_options()[name]
    return repr(value)
