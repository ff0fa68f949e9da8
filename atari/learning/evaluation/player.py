"""`Player`: a policy in the environments of one game; and the environments that a protocol and a policy need."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from inspect import signature
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.games.game import Game
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.policy import Policy
from atari.protocols import Protocol
from atari.validation import check_frameskip, check_known
from atari.vector import AtariVectorEnv
from atari.wrappers.presets import preset_protocol

IntArray = npt.NDArray[np.int64]

_PASSED = ("obs_type", "img_height", "img_width", "grayscale", "stack_num", "channels_last", "dtype", "rom")
"""The options of an environment that are the policy's choice, and that need no thought here."""


class Player:
    """A policy in the environments of one game: its actions as the environments take them, some of them random.

    Args:
        policy: what chooses actions.
        protocol: of the evaluation.
        game: that is played.

    Raises:
        ValueError: the policy needs an environment that there is not, or that the protocol does not allow.
        FileNotFoundError: there is no ROM file of the game.
    """

    def __init__(self, policy: Policy, protocol: EvaluationProtocol, game: Game) -> None:
        self._policy = policy
        self._epsilon = protocol.epsilon
        self._game = game
        self._generators: dict[int, np.random.Generator] = {}
        self.max_frames = protocol.max_frames
        given = game.legal_actions if protocol.full_action_space else game.minimal_actions
        every = tuple(action.name for action in given)
        self._count = len(every)
        environment = getattr(policy, "environment", None) or {}
        try:
            self.options = environment_options(environment, protocol)
            self._names = _actions_of(environment, game, every)
            self.make(1).close()  # so that errors are raised before the first game of an evaluation
        except TypeError as error:  # the options may be from a file
            raise ValueError(f"the environment of the policy: {error}") from error
        self._indices = np.array([every.index(name) for name in self._names], np.int64)

    def make(self, lanes: int, num_threads: int = 1) -> AtariVectorEnv:
        """Environments of the game, which wait for a reset when a game or a life has ended."""
        return AtariVectorEnv(self._game, lanes, autoreset_mode="Disabled", num_threads=num_threads, **self.options)

    def begin(self, lanes: IntArray, seeds: IntArray) -> None:
        """Begin games in some lanes, each with the seed of the game."""
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self._generators[lane] = np.random.default_rng([seed, 1])  # the policy may use the seed itself
        begin = getattr(self._policy, "begin", None)
        if begin is not None:
            begin(self._game.id, self._names, lanes, seeds)

    def act(self, observations: Any, lanes: IntArray) -> IntArray:
        """The actions of some lanes, (n,) indices of the environment's actions.

        Raises:
            ValueError: the policy returns no actions.
        """
        chosen = self._indices[self._checked(self._policy(observations, lanes), len(lanes))]
        if self._epsilon > 0:
            for row, lane in enumerate(lanes.tolist()):
                generator = self._generators[lane]
                if generator.random() < self._epsilon:
                    chosen[row] = generator.integers(self._count)
        return chosen

    def _checked(self, actions: Any, count: int) -> IntArray:
        array = np.asarray(actions)
        if array.dtype.kind not in "iu" or array.shape != (count,):
            raise ValueError(
                f"a policy must return integers of shape ({count},), one for each observation; "
                f"got {array.dtype} {array.shape}"
            )
        if ((array < 0) | (array >= len(self._names))).any():
            wrong = array[(array < 0) | (array >= len(self._names))][0]
            raise ValueError(
                f"the policy returned action {wrong}; in {self._game.id} it has {len(self._names)} actions, "
                f"0..{len(self._names) - 1} ({', '.join(self._names)})"
            )
        return array.astype(np.int64)


def environment_options(environment: Mapping[str, Any], protocol: EvaluationProtocol) -> dict[str, Any]:
    """The options of `AtariVectorEnv` that show a policy what it needs, in games as the protocol has them.

    Raises:
        TypeError, ValueError: there is no such option, or the protocol does not allow it.
    """
    if not isinstance(environment, Mapping):
        raise TypeError(f"it must be a mapping of options, got {environment!r}")
    _, *known, _ = signature(AtariVectorEnv.__init__).parameters  # without self and **wrong
    check_known("AtariVectorEnv", set(environment) - {*known, "actions"}, [*known, "actions"])
    for name, default in (("continuous", False), ("mode", None), ("difficulty", None)):
        if environment.get(name) not in (default, None):
            raise ValueError(f"games are evaluated with {name}={default}, the policy has {environment[name]!r}")
    skip = _frame_skip(environment)
    if skip != (protocol.frame_skip, protocol.frame_skip + 1):
        raise ValueError(
            f"protocol {protocol.name!r} plays {protocol.frame_skip} frames an action, the policy "
            f"{skip[0] if skip[0] + 1 == skip[1] else skip}"
        )
    options = {name: environment[name] for name in _PASSED if environment.get(name) is not None}
    return options | {"preset": _episodes(_image(environment, protocol), protocol)}


def _frame_skip(environment: Mapping[str, Any]) -> tuple[int, int]:
    """(low, high): low..high-1 frames are played for an action."""
    preset = environment.get("preset")
    if preset is not None:
        low, high = preset.frame_skip if isinstance(preset, Protocol) else (4, 5)
    else:
        skip = check_frameskip(environment.get("frameskip", 4))
        low, high = skip if isinstance(skip, tuple) else (skip, skip + 1)
    return low, high


def _image(environment: Mapping[str, Any], protocol: EvaluationProtocol) -> Protocol:
    """A protocol of environments whose images are those that the policy needs."""
    preset = environment.get("preset", None if environment else protocol.preset)
    if preset is None:
        return Protocol(max_pool=bool(environment.get("maxpool", True)))
    return preset if isinstance(preset, Protocol) else preset_protocol(str(preset))


def _episodes(image: Protocol, protocol: EvaluationProtocol) -> Protocol:
    """The protocol of environments with these images in which games begin, are played and end as in an evaluation."""
    return replace(
        _lives(protocol),
        pool_rgb=image.pool_rgb,
        max_pool=image.max_pool,
        padding=image.padding,
        end_frames=image.end_frames,
        clip_reward=False,
        repeat_action_probability=protocol.repeat_action_probability,
        full_action_space=protocol.full_action_space,
        noops=(protocol.noop_min, protocol.noop_max),
        max_num_frames_per_episode=protocol.max_frames,
        frame_skip=(protocol.frame_skip, protocol.frame_skip + 1),
    )


def _lives(protocol: EvaluationProtocol) -> Protocol:
    """A protocol of environments in which games begin, and go on after a lost life, as in an evaluation."""
    if protocol.lives == "preset":  # the stack begins anew, as in trainings whose episodes are lives
        preset = preset_protocol(protocol.preset, episodic_life=True)
        after = "continue" if preset.on_reset == "new_game" else preset.on_reset  # whole games are played
        return replace(preset, on_reset=after, seamless_lives=False, max_frames=None)
    if protocol.lives == "fire":
        return Protocol(
            order="baselines",
            fire="after_noops",
            third_action=True,
            fire_counts=False,
            episodic_life=True,
            on_reset="noop",
        )
    return Protocol(order="frames", fire="never", fire_counts=False, on_reset="continue")


def _actions_of(environment: Mapping[str, Any], game: Game, given: tuple[str, ...]) -> tuple[str, ...]:
    """The names of a policy's actions, in the order of their indices; `given` if it does not say.

    Raises:
        ValueError: it names an action that the game does not have in this protocol.
    """
    if not environment:
        return given
    chosen = environment.get("actions")
    if chosen is None:
        full = environment.get("full_action_space")
        if full is None and isinstance(preset := environment.get("preset"), str):
            full = preset_protocol(preset).full_action_space
        elif full is None and isinstance(preset, Protocol):
            full = preset.full_action_space
        chosen = [action.name for action in (game.legal_actions if full else game.minimal_actions)]
    if not isinstance(chosen, Sequence) or isinstance(chosen, str) or not chosen:
        raise ValueError(f"the actions of a policy are a sequence of names such as 'FIRE', got {chosen!r}")
    missing = [name for name in chosen if name not in given]
    if missing:
        raise ValueError(
            f"the policy has the action {missing[0]!r} in {game.id}, where this protocol has {', '.join(given)}; "
            "choose a protocol with all 18 actions, such as 'machado2018', or a policy with these"
        )
    return tuple(chosen)
