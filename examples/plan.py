#!/usr/bin/env python
"""Planning with snapshots: plays a game well without learning, and records it as a replay.

    python examples/plan.py seaquest --seconds 45 -o seaquest.a26r
    atari replay render seaquest.a26r

Without sticky actions a game is deterministic: the emulator is a perfect model of itself. A snapshot of the core costs
a microsecond and a second of play less than a millisecond, so a plan can be tried before it is played.

`plan` is a random-mutation hill climber with a rolling horizon. Before each decision it tries some tens of changes of
its plan for the next seconds, keeps the best, plays its first action, and goes on with the rest of the plan.

`explore` is for games whose first reward is far away. It is the exploration phase of Go-Explore (Ecoffet et al. 2021,
"First return, then explore"): an archive of the places that were reached, each with a snapshot; it restores one, acts
at random for a while, and keeps the new places. A place is what the game's RAM labels say of the player.
"""

import argparse
import random
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import atari
from atari.cores import NativeCore
from atari.lab import Ram
from atari.recording import RecordReplay

HOLD = 4
"""Frames for which a decision's action is held."""

DISCOUNT = 0.99
"""The factor by which a reward counts less for each later decision."""


@dataclass
class Effort:
    """How hard to search; the emulated frames bound the time.

    Attributes:
        horizon: decisions that a plan looks ahead.
        frames: emulated for each decision; of `explore`, for each decision of the whole play.
        held: the most decisions for which a random action is repeated.
        death: what a lost life costs, in multiples of the largest reward seen.
        bonus: by RAM label, how much its value at the end of a plan counts: where rewards are rare, towards the next.
    """

    horizon: int = 40
    frames: int = 4000
    held: int = 8
    death: float = 10.0
    bonus: Mapping[str, float] = field(default_factory=dict)


class Planner:
    """Plans on a core of its own, which plays `HOLD` frames a call of `act`.

    Args:
        core: without sticky actions, in the state from which to play; it is left after the play.
        actions: ALE numbers of the actions.
        effort: how hard to search.
        seed: of the random plans: the same seed gives the same play on any machine.
    """

    def __init__(self, core: NativeCore, actions: Sequence[int], effort: Effort, seed: int = 0) -> None:
        self.core, self.actions, self.effort = core, list(actions), effort
        self.random = random.Random(seed)
        self.ram = Ram(core)
        self.place = place_of(core)
        self.visits: dict[Hashable, int] = {}
        self.largest = 1.0
        """The largest reward seen."""

    def plan(self, decisions: int) -> list[int]:
        """Play up to `decisions` decisions with a rolling horizon, and return the actions."""
        core, played = self.core, list[int]()
        best = self.fragment(self.effort.horizon)
        while len(played) < decisions and not core.game_over:
            state = core.clone_state()
            value, cost = self.value(state, best), len(best)
            while cost * HOLD < self.effort.frames:
                changed = self.change(best)
                cost += len(changed)
                found = self.value(state, changed)
                if found >= value:
                    best, value = changed, found
            core.restore_state(state)
            core.act(best[0])
            self.visits[self.place()] = self.visits.get(self.place(), 0) + 1
            played.append(best[0])
            best = [*best[1:], best[-1]]
        return played

    def value(self, state: Any, plan: list[int]) -> float:
        """The discounted reward of a plan, less the cost of a lost life, and a little for a place that is new."""
        core = self.core
        core.restore_state(state)
        value, weight, lives = 0.0, 1.0, core.lives
        for action in plan:
            reward = core.act(action)
            if reward:
                self.largest = max(self.largest, abs(reward))
                value += weight * reward
            if core.lives < lives:
                return value - weight * self.effort.death * self.largest
            if core.game_over:
                break
            weight *= DISCOUNT
        for label, worth in self.effort.bonus.items():
            value += worth * (self.ram[label] or 0)
        return value + 0.1 / (1 + self.visits.get(self.place(), 0))

    def change(self, plan: list[int]) -> list[int]:
        """A plan in which one to three stretches have another action, inserted or in place; or a new plan."""
        if self.random.random() < 0.1:
            return self.fragment(len(plan))
        changed = list(plan)
        for _ in range(self.random.randint(1, 3)):
            start = int(len(plan) * self.random.random() ** 1.5)  # more often early
            length = self.random.randint(1, self.effort.held)
            stop = start + length if self.random.random() < 0.7 else start
            changed[start:stop] = [self.random.choice(self.actions)] * length
        return changed[: len(plan)]

    def fragment(self, length: int) -> list[int]:
        """Random actions, each held for a while."""
        actions: list[int] = []
        while len(actions) < length:
            actions += [self.random.choice(self.actions)] * self.random.randint(1, self.effort.held)
        return actions[:length]

    def explore(self, decisions: int) -> list[int]:
        """The best play found by going back to places and exploring from there: `decisions` decisions or fewer."""
        core = self.core
        start = Place(core.clone_state(), None, (), 0, 0)
        keys = [(*self.place(), 0)]
        places = {keys[0]: start}
        best, spent = start, 0
        while spent * HOLD < self.effort.frames * decisions:
            key = min((self.random.choice(keys) for _ in range(6)), key=lambda each: places[each].visits)
            place = places[key]
            place.visits += 1
            core.restore_state(place.state)
            lives, score, actions = core.lives, place.score, list[int]()
            for action in self.fragment(3 * self.effort.horizon):
                score += core.act(action)
                spent += 1
                actions.append(action)
                if core.lives < lives or core.game_over or place.length + len(actions) >= decisions:
                    break
                reached = (*self.place(), score)
                known = places.get(reached)
                if known is None or place.length + len(actions) < known.length:
                    if known is None:
                        keys.append(reached)
                    place = Place(core.clone_state(), place, tuple(actions), place.length + len(actions), score)
                    places[reached], actions = place, []
                    if (score, -place.length) > (best.score, -best.length):
                        best = place
        core.restore_state(best.state)
        return best.way()


@dataclass(eq=False)
class Place:
    """A place that was reached: its snapshot, the way from the place before, decisions and score so far."""

    state: Any
    before: "Place | None"
    actions: tuple[int, ...]
    length: int
    score: int
    visits: int = 0

    def way(self) -> list[int]:
        """All actions from the start."""
        place: Place | None = self
        parts = []
        while place is not None:
            parts.append(place.actions)
            place = place.before
        return [action for part in reversed(parts) for action in part]


def place_of(core: NativeCore) -> Callable[[], tuple[int, ...]]:
    """A function that returns where the player is: its room and position, in steps of 8, as far as there are labels."""
    labels = core.game.ram_labels
    rooms = [label.index for name, label in labels.items() if name.startswith(("room", "level"))]
    names = ("player_x", "player_y", "player_row", "player_column", "player_0_x", "player_0_y")
    positions = [labels[name].index for name in names if name in labels]

    def place() -> tuple[int, ...]:
        ram = core.ram()
        return (*[int(ram[index]) for index in rooms], *[int(ram[index]) >> 3 for index in positions])

    return place


def play(
    game: str, *, seconds: float, effort: Effort, method: str = "plan", seed: int = 0, **options: Any
) -> list[int]:
    """The actions (indices into the minimal actions, each held for `HOLD` frames) of a good play of a game."""
    env = atari.AtariEnv(game, frameskip=HOLD, repeat_action_probability=0.0, **options)
    env.reset(seed=0)
    core = NativeCore(game, frame_skip=HOLD, repeat_action_probability=0.0, **options)
    core.restore_state(env.core.clone_state())
    numbers = [int(action) for action in core.game.minimal_actions]
    planner = Planner(core, numbers, effort, seed)
    decisions = int(seconds * 60 / HOLD)
    actions = planner.explore(decisions) if method == "explore" else []
    actions += planner.plan(decisions - len(actions))
    return [numbers.index(action) for action in actions]


def record(game: str, actions: Sequence[int], path: str | Path, **options: Any) -> float:
    """Play the actions again into a replay file; the score."""
    env = atari.make(game, frameskip=HOLD, repeat_action_probability=0.0, **options)
    recording = RecordReplay(env, path)
    recording.reset(seed=0)
    score = sum(float(recording.step(action)[1]) for action in actions)
    recording.close()
    return score


def add_arguments(parser: argparse.ArgumentParser, default: Effort) -> None:
    """Arguments for the fields of `Effort` and for the game's settings."""
    for name in ("horizon", "frames", "held", "death"):
        value = getattr(default, name)
        parser.add_argument(f"--{name}", type=type(value), default=value, help="see Effort (default: %(default)s)")
    parser.add_argument("--bonus", nargs=2, action="append", metavar=("LABEL", "WORTH"), default=[], help="see Effort")
    parser.add_argument("--mode", type=int, help="of the game")
    parser.add_argument("--difficulty", type=int, help="of the game")


def chosen_effort(chosen: argparse.Namespace) -> Effort:
    """The effort that the arguments say."""
    bonus = {label: float(worth) for label, worth in chosen.bonus}
    return Effort(chosen.horizon, chosen.frames, chosen.held, chosen.death, bonus)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("game", help="such as seaquest")
    parser.add_argument("-o", "--output", type=Path, help="the replay; default GAME.a26r")
    parser.add_argument("--seconds", type=float, default=45.0, help="of play (default: %(default)s)")
    parser.add_argument("--method", choices=("plan", "explore"), default="plan", help="(default: %(default)s)")
    add_arguments(parser, Effort())
    parser.add_argument("--seed", type=int, default=0, help="of the search (default: %(default)s)")
    chosen = parser.parse_args()
    effort = chosen_effort(chosen)
    options = {"mode": chosen.mode, "difficulty": chosen.difficulty}
    actions = play(
        chosen.game, seconds=chosen.seconds, effort=effort, method=chosen.method, seed=chosen.seed, **options
    )
    path = chosen.output or Path(f"{chosen.game}.a26r")
    score = record(chosen.game, actions, path, **options)
    print(f"{chosen.game}: score {score:g} in {len(actions) * HOLD} frames, {path}")


if __name__ == "__main__":
    main()
