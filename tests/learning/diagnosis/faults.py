"""Agents with faults put in by a seed, and whether a diagnosis names them: the lane of `atari diagnose`.

Twelve games have an agent without a fault: two shipped image policies, five small networks that the lane trains from
RAM, and five rules from labels. A fault is a wrapper around the agent's function. It is drawn from a seed, from those
that are there in the agent's games: a press that it uses, a place that most of its games reach, and so on.

    python tests/learning/diagnosis/faults.py --agents build/fault-agents --seed 1000

trains the agents that the folder lacks, draws 40 agents, prints what the diagnosis says of each, and says how many are
right: the first finding has the kind and the place of the fault. The agents without a fault must have no finding.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import atari
from atari.lab.labels import Labels, labels_of
from atari.learning import PROTOCOLS, ScoresPolicy, load_policy
from atari.learning.diagnosis.behaviour import behaviour
from atari.learning.diagnosis.findings import Finding
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.evaluation.played import played_task, resolve_games
from atari.policy import LoadedPolicy

Array = np.ndarray[Any, Any]

EXAMPLES = Path(__file__).parents[3] / "examples"
SHIPPED = {"breakout": "breakout-pqn", "qbert": "qbert-pqn"}
TRAINED = ("space_invaders", "ms_pacman", "boxing", "asterix", "demon_attack")
TRAINING = ("--fast", "--obs-type", "ram", "--sticky", "0.25", "--workers", "1", "--total-steps", "700000")
KINDS = ("unused action", "unseen object", "random from", "side not visited", "delayed actions", "loop")
EPSILON = PROTOCOLS["dopamine"].epsilon
_OPPOSITE = {"left": "RIGHT", "right": "LEFT", "top": "DOWN", "bottom": "UP"}
_PRESSES = {"LEFT": "LEFT", "RIGHT": "RIGHT", "UP": "UP", "DOWN": "DOWN", "FIRE": "FIRE"}


# Rules from labels. Each gets the values of all labels by name, (n,) int, and returns a score for each action by name.


def pong(see: dict[str, Array]) -> dict[str, Array]:
    """Follow the ball, and serve."""
    above = np.where(see["ball_x"] == 0, 0.0, see["player_y"] + 8.0 - see["ball_y"])
    return {"NOOP": 0 * above + 6, "RIGHT": above, "LEFT": -above, "FIRE": 5.0 + (see["ball_x"] == 0) * 10}


def freeway(see: dict[str, Array]) -> dict[str, Array]:
    """Go up, and wait or go back where a car of the next lane comes near."""
    danger = np.zeros(len(see["player_y"]))
    for lane in range(10):
        row = 166 - 16 * lane  # where the lane's cars are
        ahead = np.exp(-(((see["player_y"] - row - 10) / 10.0) ** 2))
        coming = (see[f"car_{lane}_x"] - 44) * (1 if lane >= 5 else -1)  # the upper lanes go to the left
        danger = danger + ahead * np.exp(-(((coming - 8) / 14.0) ** 2))
    return {"UP": 0.55 - danger, "NOOP": 0 * danger, "DOWN": danger - 0.85}


def air_raid(see: dict[str, Array]) -> dict[str, Array]:
    """Go below the lowest enemy, not far from a building, away from a shot, and fire."""
    enemies = [(see[f"enemy_{number}_x"], see[f"enemy_{number}_y"]) for number in range(3)]
    weights = [np.exp(y / 20.0) for _, y in enemies]
    target = sum(x * weight for (x, _), weight in zip(enemies, weights, strict=True)) / sum(weights)
    shot = see["enemy_shot_x"] - see["player_x"]
    away = np.where(np.abs(shot) < 14, -np.sign(shot + 0.5) * (14 - np.abs(shot)), 0.0) * (see["enemy_shot_y"] > 100)
    home = (see["building_0_x"] + see["building_1_x"]) / 2
    go = 0.85 * target + 0.15 * home - see["player_x"] + 3 * away
    return {"FIRE": 6.0 - np.abs(go), "RIGHTFIRE": go, "LEFTFIRE": -go, "RIGHT": go * 0.8, "LEFT": go * -0.8}


def carnival(see: dict[str, Array]) -> dict[str, Array]:
    """Go below the nearest group of targets, or the duck, and fire there when no shot is on its way."""
    duck = np.where(see["duck_x"] > 0, see["duck_x"], np.inf)
    go = _nearest([*(see[f"row_{number}_x"] for number in range(6)), duck], see["player_x"])
    fire = np.where(see["player_shot_y"] == 0, 3.0, -60.0) - np.abs(go) + 8 * (np.abs(go) < 3)
    return {"NOOP": 0 * go + 1, "RIGHT": go, "LEFT": -go, "FIRE": fire}


def phoenix(see: dict[str, Array]) -> dict[str, Array]:
    """Go below the nearest enemy, fire when no shot is on its way, and use the shield when a shot comes near."""
    enemies = [see[f"enemy_{number}_x"] for number in range(8)]
    go = _nearest([np.where(x > 0, x, np.inf) for x in enemies], see["player_x"])
    lowest = np.max([see[f"enemy_shot_{number}_y"] for number in range(4)], 0)
    ready = np.where(see["player_shot_y"] == 0, 0.0, -60.0)
    fire = {"FIRE": 6.0 - np.abs(go) + ready, "RIGHTFIRE": go + ready + 1, "LEFTFIRE": -go + ready + 1}
    shield = np.where((lowest > 165) & (lowest < 177), 100.0, -200.0)
    return {"NOOP": 0 * go + 2, "RIGHT": go, "LEFT": -go, "DOWN": shield, **fire}


def _nearest(things: Sequence[Array], player: Array) -> Array:
    """The way to the nearest of some things, which may be at infinity; 0 if there is none."""
    ways = np.stack(things) - player
    nearest = ways[np.abs(ways).argmin(0), np.arange(ways.shape[1])]
    return np.where(np.isfinite(nearest), nearest, 0.0)


RULES: dict[str, Callable[[dict[str, Array]], dict[str, Array]]] = {
    "pong": pong,
    "freeway": freeway,
    "air_raid": air_raid,
    "carnival": carnival,
    "phoenix": phoenix,
}
GAMES = (*SHIPPED, *TRAINED, *RULES)


@dataclass(frozen=True)
class Agent:
    """An agent without a fault: its scores of the actions, and what it needs to be played."""

    game: str
    scores: Callable[[Array], Array]
    facts: dict[str, Any]

    @property
    def ram(self) -> bool:
        """Whether it sees RAM."""
        return self.game not in SHIPPED

    def policy(self, scores: Callable[[Array], Array] | None = None) -> LoadedPolicy:
        """The agent, or one with other scores, as a policy."""
        return load_policy(ScoresPolicy(scores or self.scores, name=self.game, **self.facts))


def agent(game: str, folder: Path) -> Agent:
    """The agent of a game; networks that the lane trains are in `folder`."""
    if game in RULES:
        labels = labels_of(atari.games[game])
        names = [action.name for action in atari.games[game].minimal_actions]
        return Agent(game, partial(_rule_scores, RULES[game], labels, names), {"environment": {"obs_type": "ram"}})
    loaded: Any = load_policy(EXAMPLES / SHIPPED[game] if game in SHIPPED else folder / game)
    # The scores of the whole network, with what it has learnt about the size of its input.
    return Agent(game, loaded._policy._scores, {"task": loaded.task, "environment": loaded.environment})


def _rule_scores(rule: Any, labels: Labels, names: Sequence[str], observations: Array) -> Array:
    values, _ = labels.evaluate(_rams(observations))
    found = rule(dict(zip(labels.names, values.astype(float), strict=True)))
    return np.stack([np.asarray(found.get(name, np.full(len(observations), -1e3)), float) for name in names], 1)


def _rams(observations: Array) -> Array:
    """The newest RAM of each observation, (n, 128)."""
    return np.ascontiguousarray(observations.reshape(len(observations), -1, 128)[:, -1])


def train(folder: Path) -> None:
    """Train the networks that a folder lacks, each in one or two minutes."""
    for game in TRAINED:
        if not (folder / game / "policy.pt").exists():
            command = [sys.executable, "-m", "atari", "train", "ppo", game, *TRAINING, "--games", "0"]
            subprocess.run([*command, "-o", str(folder / game)], check=True, stdout=subprocess.DEVNULL)


def play(policy: LoadedPolicy, game: str, games: int, seed: int) -> Plays:
    """Games of a policy by Dopamine's protocol."""
    protocol = PROTOCOLS["dopamine"]
    task = played_task(resolve_games(game)[0], protocol, policy)
    return play_games(policy, task, games, seed, epsilon=protocol.epsilon)


# Faults.


@dataclass
class Wrapper:
    """A policy whose action a fault changes; it keeps what the fault needs for each lane.

    `change(chosen, observations, lanes, memory)` returns the actions; a memory is a dictionary of its lane's game, with
    the number of the step as "step", and a generator as "rng".
    """

    agent: Agent
    change: Callable[[Array, Array, list[dict[str, Any]]], Array]
    memories: dict[int, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.name = self.agent.game
        self.task = self.agent.facts.get("task")
        self.environment = self.agent.facts.get("environment")

    def begin(self, game: str, actions: Sequence[str], lanes: Array, seeds: Array) -> None:
        """Begin games."""
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self.memories[lane] = {"step": -1, "rng": np.random.default_rng([seed, 7])}

    def __call__(self, observations: Array, lanes: Array) -> Array:
        """The actions."""
        memories = [self.memories[lane] for lane in lanes.tolist()]
        for memory in memories:
            memory["step"] += 1
        return self.change(self.agent.scores(observations).argmax(1), observations, memories)


@dataclass(frozen=True)
class Fault:
    """An agent with a fault: its kind and its place, as a diagnosis should name them."""

    game: str
    kind: str
    place: str
    number: int | None
    near: int
    policy: LoadedPolicy

    def found(self, findings: Sequence[Finding]) -> bool:
        """Whether the first finding has the kind and the place; a score or a step may differ by `near`."""
        if not findings or findings[0].kind != self.kind:
            return False
        if self.number is None or self.kind == "delayed actions":
            return findings[0].place == self.place
        unit = self.place.split()[0] == "step"
        found = findings[0].number
        return (
            (findings[0].place.split()[0] == "step") == unit
            and found is not None
            and (abs(found - self.number) <= self.near)
        )


@dataclass
class Faults:
    """Draws faults of one agent, from those that are there in its games.

    `plays` are games of the agent without a fault.
    """

    agent: Agent
    plays: Plays

    def draw(self, kind: str, rng: np.random.Generator) -> Fault | None:
        """A fault of a kind; None if this agent cannot have one."""
        drawn: Fault | None = getattr(self, "_" + kind.split()[-1])(rng)
        return drawn

    def _fault(self, kind: str, place: str, policy: Any, number: int | None = None, near: int = 0) -> Fault:
        return Fault(self.agent.game, kind, place, number, near, load_policy(policy))

    def _action(self, rng: np.random.Generator) -> Fault | None:
        """No action with some press is taken; the best other action is."""
        actions, shares = self.plays.actions, self._shares()
        options = []
        for press in ("UP", "DOWN", "LEFT", "RIGHT", "FIRE"):
            has = np.array([press in name for name in actions])
            # Without the first shot, Breakout and Pong do not begin.
            serves = press == "FIRE" and self.agent.game in ("breakout", "pong")
            if shares[has].sum() >= 0.02 and not has.all() and not serves:
                options.append((press, has))
        if not options:
            return None
        press, has = options[rng.integers(len(options))]

        def masked(observations: Array) -> Array:
            return np.where(has, -np.inf, self.agent.scores(observations).astype(float))

        return self._fault("unused action", press, self.agent.policy(masked))

    def _object(self, rng: np.random.Generator) -> Fault | None:
        """The bytes of the positions of some objects are 0 in what the agent sees."""
        if not self.agent.ram:
            return None
        kinds = self._objects_near()
        if not kinds:
            return None
        for name in rng.permutation(sorted(kinds)).tolist():
            policy = self.agent.policy(partial(_blind, self.agent.scores, kinds[name]))
            # An agent that nothing is left to see for does always the same, which is another fault.
            actions = np.concatenate([one.actions for one in play(policy, self.agent.game, 3, 77)])
            if (np.bincount(actions) > 0.05 * len(actions)).sum() >= 2:
                return self._fault("unseen object", name, policy)
        return None

    def _from(self, rng: np.random.Generator) -> Fault | None:
        """From some score or step on, actions are drawn uniformly."""
        place = self._place(rng)

        def change(chosen: Array, observations: Array, memories: list[dict[str, Any]]) -> Array:
            for row, on in enumerate(place.reached(observations, memories)):
                if on:
                    chosen[row] = memories[row]["rng"].integers(len(self.plays.actions))
            return chosen

        wrapped = Wrapper(self.agent, change)
        return self._fault("random from", place.words, wrapped, place.number, place.near)

    def _loop(self, rng: np.random.Generator) -> Fault | None:
        """From some score or step on, a cycle of 2 to 12 actions is repeated, in which nothing is shot."""
        names = self.plays.actions
        usable = [index for index, name in enumerate(names) if "FIRE" not in name]
        for _ in range(4):
            place = self._place(rng)
            cycle = rng.choice(usable, size=rng.integers(2, 13))
            if len(set(cycle.tolist())) < 2:
                continue
            wrapped = Wrapper(self.agent, partial(_cycle, place, cycle))
            if self._gets_nothing(load_policy(wrapped), place):
                return self._fault("loop", place.words, wrapped, place.number, place.near)
        return None

    def _gets_nothing(self, policy: LoadedPolicy, place: "Place") -> bool:
        """Whether most games that reach a place go on for 150 steps without a reward."""
        plays = play(policy, self.agent.game, 6, 77)
        without = []
        for one in plays:
            key = one.totals if place.unit == "points" else np.arange(len(one))
            after = np.flatnonzero(key >= place.number)
            if len(after):
                rewarded = np.flatnonzero(one.rewards[after[0] + 1 :] > 0)
                without.append(len(one) - after[0] if not len(rewarded) else 0)
        return len(without) >= 4 and float(np.mean(np.array(without) >= 150)) > 0.5

    def _actions(self, rng: np.random.Generator) -> Fault | None:
        """Each action is played some steps after it was chosen."""
        delay = int(rng.integers(1, 13))

        def change(chosen: Array, observations: Array, memories: list[dict[str, Any]]) -> Array:
            for row, memory in enumerate(memories):
                queue = memory.setdefault("queue", [0] * delay)
                queue.append(int(chosen[row]))
                chosen[row] = queue.pop(0)
            return chosen

        wrapped = Wrapper(self.agent, change)
        return self._fault("delayed actions", f"{delay} step{'s' * (delay > 1)}", wrapped, delay)

    def _visited(self, rng: np.random.Generator) -> Fault | None:
        """Beyond the middle of the player's range, the agent goes back."""
        if not self.agent.ram:
            return None
        labels, names = self.plays.labels, self.plays.actions
        options = []
        for axis, low, high in (("player_x", "left", "right"), ("player_y", "top", "bottom")):
            if axis not in labels.names or labels.game.ram_labels[axis].kind != f"position_{axis[-1]}":
                continue
            number = labels.names.index(axis)
            every = np.concatenate([labels.evaluate(one.rams)[0][number] for one in self.plays])
            starts = [int(labels.evaluate(one.rams[10:11])[0][number, 0]) for one in self.plays]
            ends = np.quantile(every, [0.01, 0.99])
            middle = float(ends.mean())
            for side, beyond in ((low, -1), (high, 1)):
                away = _OPPOSITE[side]
                room = (middle - np.median(starts)) * beyond >= -0.05 * np.ptp(ends)
                if away in names and np.ptp(ends) >= 24 and room and np.mean((every - middle) * beyond > 0) > 0.05:
                    options.append((side, number, middle, beyond, names.index(away)))
        if not options:
            return None
        for choice in rng.permutation(len(options)).tolist():
            side, number, middle, beyond, away = options[choice]

            def change(
                chosen: Array,
                observations: Array,
                memories: Any,
                number: int = number,
                middle: float = middle,
                beyond: int = beyond,
                away: int = away,
            ) -> Array:
                values = labels.evaluate(_rams(observations))[0][number]
                return np.where((values - middle) * beyond > 0, away, chosen)

            wrapped = Wrapper(self.agent, change)
            plays = play(load_policy(wrapped), self.agent.game, 6, 77)
            every = np.concatenate([labels.evaluate(one.rams)[0][number] for one in plays])
            # At least 40 % must not be visited; a thing that cannot stop goes on to the side.
            if np.mean((every - middle) * beyond > 0.2 * abs(middle - self._end(number, beyond))) < 0.002:
                return self._fault("side not visited", side, wrapped)
        return None

    def _end(self, number: int, beyond: int) -> float:
        """The end of the range of a label on a side."""
        every = np.concatenate([self.plays.labels.evaluate(one.rams)[0][number] for one in self.plays])
        return float(np.quantile(every, 0.99 if beyond > 0 else 0.01))

    def _shares(self) -> Array:
        counts = np.bincount(np.concatenate([one.actions for one in self.plays]), minlength=len(self.plays.actions))
        return counts / counts.sum()

    def _place(self, rng: np.random.Generator) -> "Place":
        """A score, or a step, that most games reach long before their ends."""
        labels = self.plays.labels
        shown = [number for number, name in enumerate(labels.names) if labels.game.ram_labels[name].kind == "score"]
        by_score = self.agent.ram and self.agent.game not in ("pong", "freeway") and rng.random() < 0.7
        if by_score:
            same = [(labels.evaluate(one.rams)[0][shown].sum(0)[40:] == one.totals[40:]).mean() for one in self.plays]
            by_score = bool(np.mean(same) > 0.9)
        part = rng.uniform(0.1, 0.5)
        length = float(np.quantile([len(one) for one in self.plays], 0.2))
        step = max(int(part * length), 20)
        if not by_score:
            return Place("step", step, max(10, step // 10))
        number = max(1, int(np.quantile([one.totals[min(step, len(one) - 1)] for one in self.plays], 0.3)))
        rewards = np.concatenate([one.rewards[one.rewards > 0] for one in self.plays])
        near = max(number // 10, int(np.quantile(rewards, 0.9)))
        return Place("points", number, near, partial(_shown_score, labels, shown))

    def _objects_near(self) -> dict[str, list[int]]:
        """The bytes of kinds of objects that are often near the player at lost lives, by the kind's name."""
        from atari.learning.diagnosis.senses import _kinds, _near

        near = _near(self.plays)
        return {kind.name: kind.bytes_of(self.plays) for kind in _kinds(self.plays) if near.get(kind.name, 0) >= 0.3}


@dataclass(frozen=True)
class Place:
    """Where a fault begins: at a step, or at a score, which `score` reads from observations."""

    unit: str
    number: int
    near: int
    score: Callable[[Array], Array] | None = None

    @property
    def words(self) -> str:
        """As a finding names it."""
        return f"step {self.number}" if self.unit == "step" else f"{self.number} points"

    def reached(self, observations: Array, memories: list[dict[str, Any]]) -> Iterator[bool]:
        """For each lane, whether its game has reached the place, now or before."""
        steps = np.array([memory["step"] for memory in memories])
        now = steps >= self.number if self.score is None else self.score(observations) >= self.number
        for memory, on in zip(memories, now.tolist(), strict=True):
            # The score on the screen of the first steps is that of another game.
            memory["reached"] = memory.get("reached", False) or (on and (self.score is None or memory["step"] > 20))
            yield memory["reached"]


def _shown_score(labels: Labels, shown: Sequence[int], observations: Array) -> Array:
    return np.asarray(labels.evaluate(_rams(observations))[0][list(shown)].sum(0))


def _blind(scores: Callable[[Array], Array], hidden: Sequence[int], observations: Array) -> Array:
    seen = observations.copy()
    seen[..., list(hidden)] = 0
    return scores(seen)


def _cycle(place: Place, cycle: Array, chosen: Array, observations: Array, memories: list[dict[str, Any]]) -> Array:
    for row, on in enumerate(place.reached(observations, memories)):
        if on:
            memories[row]["turn"] = memories[row].get("turn", -1) + 1
            chosen[row] = cycle[memories[row]["turn"] % len(cycle)]
    return chosen


def draw(count: int, seed: int, agents: Sequence[Faults]) -> Iterator[Fault]:
    """Agents with faults: each kind in turn, in games drawn from the seed, no fault twice."""
    rng = np.random.default_rng(seed)
    drawn: set[tuple[str, str, str]] = set()
    while len(drawn) < count:
        kind = KINDS[len(drawn) % len(KINDS)]
        for number in rng.permutation(len(agents)).tolist():
            fault = agents[number].draw(kind, rng)
            if fault is not None and (fault.game, fault.kind, fault.place) not in drawn:
                drawn.add((fault.game, fault.kind, fault.place))
                yield fault
                break
        else:
            raise ValueError(f"no agent can have another fault of the kind {kind!r}")


def main() -> int:
    """Play the agents without faults and those with faults; 0 if the thresholds hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=Path, required=True, help="the folder of the trained networks")
    parser.add_argument("--seed", type=lambda text: int(text, 0), default=1000)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--games", type=int, default=30)
    parser.add_argument("--only", nargs="*", default=GAMES, help="games")
    given = parser.parse_args()
    train(given.agents)
    agents, wrong = [], 0
    for game in given.only:
        begun = time.perf_counter()
        plays = play((whole := agent(game, given.agents)).policy(), game, given.games, given.seed)
        agents.append(Faults(whole, plays))
        findings = behaviour(plays)
        wrong += bool(findings)
        print(
            f"{game}: {plays.scores.mean():.0f}, {time.perf_counter() - begun:.0f} s",
            *findings,
            sep="\n    ",
            flush=True,
        )
    right = 0
    for fault in draw(given.count, given.seed, agents):
        begun = time.perf_counter()
        findings = behaviour(play(fault.policy, fault.game, given.games, given.seed + 1))
        right += fault.found(findings)
        print(
            f"{'right' if fault.found(findings) else 'WRONG'}: {fault.game}, {fault.kind}, {fault.place} "
            f"({time.perf_counter() - begun:.0f} s)",
            *[f"{one.kind}, {one.place}: {one}" for one in findings],
            sep="\n    ",
            flush=True,
        )
    print(f"{right} of {given.count} faults are named; {wrong} of {len(agents)} agents without a fault have a finding")
    return int(right < 0.8 * given.count or wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
