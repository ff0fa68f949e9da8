"""Self-play in Pong: PPO, one policy for both sides, and its own checkpoints as further opponents.

    python examples/self_play.py train runs/self     # a run folder; the same command goes on after a kill
    python examples/self_play.py elo runs/self       # a round-robin of the checkpoints: their Elo ratings
    python examples/self_play.py match runs/self     # the best two of `elo`: best.a26r, and best.mp4 with sound

The policy sees, of the last two steps, where the ball and both paddles are and how the ball moves, from RAM. The second
player sees Pong in a mirror, so both sides play the same game. In half of the games both sides learn; in the other half
one side is a checkpoint. The one-player game serves as a test only: its opponent is part of the cartridge. Needs the
extras `learn` and `video`.
"""

import argparse
import csv
import random
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
import torch.nn.functional as F
from torch import Tensor, nn

import atari
from atari.games.actions import Action
from atari.learning import Encoder, RunFolder
from atari.learning.agents.ppo import ActorCritic
from atari.learning.evaluation.elo import elo_ratings
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay

MODES = (3, 4)
"""A step moves the ball up or down by less in mode 3 than in the one-player game, and by more in mode 4."""
ALONE = atari.Task.of("pong", obs_type="ram", repeat_action_probability=0.25)
TASK = ALONE.replace(players=2, mode=MODES[-1])
"""The games of two players. Sticky actions make each game another one."""
ACTIONS = (Action.FIRE, Action.RIGHTFIRE, Action.LEFTFIRE)
"""FIRE serves, and changes nothing otherwise. So these are all actions that differ in effect, and serve."""
INDICES = np.array([atari.games["pong"].minimal_actions.index(action) for action in ACTIONS])
BYTES = [atari.games["pong"].ram_labels[name].index for name in ("ball_x", "ball_y", "player_y", "enemy_y")]
STACK, VALUES = 2, len(BYTES) + 4
Bytes = npt.NDArray[np.uint8]


# Observations


class Sight:
    """What both players see: (games, 2, STACK, VALUES) uint8.

    The values are ball x, ball y, the own paddle, the other paddle, how far the ball is below the own paddle, how far
    it has moved in x and in y, and the player, 0 or 255. 128 stands for a distance of 0. Columns x and 256 - x of the
    ball are mirror images; 0 is no ball.
    """

    def __init__(self, ram: Bytes) -> None:
        self.seen = np.zeros((len(ram), 2, STACK, VALUES), np.uint8)
        self.ball = np.zeros((2, len(ram)), np.int64)
        self.begin(ram, np.ones(len(ram), np.bool_))

    def begin(self, ram: Bytes, games: npt.NDArray[np.bool_]) -> Bytes:
        """Fill the stacks of some games with the RAM (games, 128) at their start."""
        self.ball[:, games] = 0  # the ball of the game before
        self.seen[games] = self._newest(ram)[games]
        return self.seen

    def push(self, ram: Bytes) -> Bytes:
        """Add the RAM (games, 128) after a step of all games."""
        self.seen = np.concatenate([self.seen[:, :, 1:], self._newest(ram)], 2)
        return self.seen

    def _newest(self, ram: Bytes) -> Bytes:
        """What both players see at a time, (games, 2, 1, VALUES)."""
        x, y, first, second = ram[:, BYTES].T.astype(np.int64)
        before = self.ball
        self.ball = np.stack([x, y])
        flies = (x > 0) & (before[0] > 0) & (abs(x - before[0]) < 48)  # farther apart, it was served in between
        dx, dy = np.where(flies, self.ball - before, 0)
        mine = _values(x, y, first, second, dx, dy, 0)
        yours = _values(np.where(x > 0, 256 - x, 0), y, second, first, -dx, dy, 255)
        return np.stack([mine, yours], 1)[:, :, None]


def _values(x: Any, y: Any, own: Any, other: Any, dx: Any, dy: Any, player: int) -> Bytes:
    distances = (128 + part for part in (y - own, 4 * dx, 4 * dy))
    return np.stack([x, y, own, other, *distances, np.full_like(x, player)], 1).clip(0, 255).astype(np.uint8)


def make_network() -> ActorCritic:
    """A policy and a value function, for one side's observations (batch, STACK, VALUES)."""
    return ActorCritic(Encoder((STACK, VALUES), "mlp", normalize=True), len(ACTIONS))


@torch.no_grad()
def choose(network: ActorCritic, seen: Bytes) -> Tensor:
    """Draw an action for each observation, (batch,) int64."""
    return torch.multinomial(F.softmax(network.scores(torch.from_numpy(seen)), 1), 1)[:, 0]


# Games of the policy against itself and against checkpoints


class SelfPlayGames:
    """Games whose seats, (game, player), are the learner's or a checkpoint's, in equal parts of each mode.

    Of four games, two have two seats of the learner, one has its seat on the left, and one on the right.
    """

    def __init__(self, games: int, opponents: int, seed: int) -> None:
        tasks = [TASK.replace(mode=mode) for mode in MODES]
        lanes = games // len(MODES)
        self.envs = [atari.AtariVectorEnv(task, lanes, autoreset_mode="SameStep", num_threads=1) for task in tasks]
        numbers = np.arange(games)
        learns = np.ones((games, 2), np.bool_)
        shared = numbers[numbers % 4 >= 2]
        learns[shared, shared % 2] = False
        self.learners = np.nonzero(learns)
        self.others = [np.nonzero(~learns)[0][start::opponents] for start in range(opponents)]
        self.pool: list[ActorCritic] = []
        ram = [envs.reset(seed=seed + 1000 * index)[0] for index, envs in enumerate(self.envs)]
        self.sight = Sight(np.concatenate(ram))
        self.actions = np.zeros((games, 2), np.int64)

    @property
    def observations(self) -> Tensor:
        """What the learner's seats see, (seats, STACK, VALUES)."""
        return torch.from_numpy(self.sight.seen[self.learners])

    def step(self, actions: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Play a step with the learner's actions.

        Returns:
            Of the learner's seats: rewards (seats,), terminations (seats,), truncations (seats,), float32, and what
            they saw at the end of the step, before the reset of a game, (seats, STACK, VALUES) uint8.
        """
        self.actions[self.learners] = actions.numpy()
        for network, games in zip(self.pool, self.others, strict=True):
            seats = games, games % 2
            self.actions[seats] = choose(network, self.sight.seen[seats]).numpy()
        parts = np.split(INDICES[self.actions], len(MODES))
        results = [envs.step(part) for envs, part in zip(self.envs, parts, strict=True)]
        ram, rewards, terminations, truncations = map(np.concatenate, zip(*(each[:4] for each in results), strict=True))
        last = np.concatenate([info.get("final_obs", ram) for ram, *_, info in results])
        over = (terminations | truncations).any(1)
        after = self.sight.push(np.where(over[:, None], last, ram))[self.learners]
        if over.any():
            self.sight.begin(ram, over)
        mine = (torch.from_numpy(part[self.learners]).float() for part in (rewards, terminations, truncations))
        return *mine, torch.from_numpy(after)

    def state(self) -> dict[str, Any]:
        """The games and what is seen of them."""
        return {"envs": [envs.snapshot() for envs in self.envs], "sight": vars(self.sight)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a state."""
        for envs, snapshot in zip(self.envs, state["envs"], strict=True):
            envs.restore(None, snapshot)
        vars(self.sight).update(state["sight"])


# Proximal policy optimisation


@dataclass(frozen=True)
class Options:
    """Numbers of the training; `steps` are those of both players together, of 4 frames each."""

    steps: int = 20_000_000
    games: int = 64
    opponents: int = 4
    horizon: int = 128
    minibatch: int = 1024
    epochs: int = 3
    learning_rate: float = 1.2e-3
    gamma: float = 0.99
    gae_lambda: float = 0.95
    clip: float = 0.2
    entropy: float = 0.01
    checkpoints: int = 12
    seed: int = 0


def advantages_of(
    rewards: Tensor, values: Tensor, following: Tensor, terminations: Tensor, truncations: Tensor, options: Options
) -> Tensor:
    """Generalised advantages (Schulman et al. 2016) of steps, (steps, seats) each.

    `following` has the values of what follows each step. A truncation cuts a game off: what would have followed still
    counts. Nothing follows a termination.
    """
    advantages, later = torch.zeros_like(rewards), torch.zeros(rewards.shape[1])
    for step in reversed(range(len(rewards))):
        error = rewards[step] + options.gamma * (1 - terminations[step]) * following[step] - values[step]
        same_game = (1 - terminations[step]) * (1 - truncations[step])
        later = error + options.gamma * options.gae_lambda * same_game * later
        advantages[step] = later
    return advantages


class Learner:
    """The network, its games and its optimiser."""

    def __init__(self, options: Options) -> None:
        torch.manual_seed(options.seed)
        self.options = options
        self.random = random.Random(options.seed)
        self.games = SelfPlayGames(options.games, options.opponents, options.seed)
        self.network = make_network()
        self.network.encoder.observe(self.games.observations)
        self.optimizer = torch.optim.Adam(self.network.parameters(), options.learning_rate, eps=1e-5)
        self.seats = len(self.games.learners[0])
        self.steps = 0

    def update(self, pool: list[ActorCritic]) -> None:
        """Play `horizon` steps, against some of the pool, and learn from them."""
        options = self.options
        self.games.pool = self.random.choices(pool, k=options.opponents)
        memory = self._play()
        self.steps += options.horizon * self.seats
        self.optimizer.param_groups[0]["lr"] = options.learning_rate * max(0.02, 1 - self.steps / options.steps)
        for _ in range(options.epochs):
            for chosen in torch.randperm(options.horizon * self.seats).split(options.minibatch):
                self._learn(*(part[chosen] for part in memory))
        self.network.encoder.observe(memory[0][:: options.games])

    @torch.no_grad()
    def _play(self) -> list[Tensor]:
        """Observations, actions, their log-probabilities, advantages and returns, (steps * seats, ...) each."""
        horizon, size = self.options.horizon, (self.options.horizon, self.seats)
        seen = torch.zeros(*size, STACK, VALUES, dtype=torch.uint8)
        actions = torch.zeros(*size, dtype=torch.int64)
        log_probs, rewards, terminations, truncations, following = torch.zeros(5, *size).unbind()
        values = torch.zeros(horizon + 1, self.seats)
        for step in range(horizon):
            seen[step] = self.games.observations
            logits, values[step] = self.network(seen[step])
            distribution = F.log_softmax(logits, 1)
            drawn = torch.multinomial(distribution.exp(), 1)
            actions[step], log_probs[step] = drawn[:, 0], distribution.gather(1, drawn)[:, 0]
            rewards[step], terminations[step], truncations[step], after = self.games.step(actions[step])
            if truncations[step].any():
                following[step] = self.network(after)[1]
        values[horizon] = self.network(self.games.observations)[1]
        following = torch.where(truncations > 0, following, values[1:])
        advantages = advantages_of(rewards, values[:-1], following, terminations, truncations, self.options)
        returns = advantages + values[:-1]
        normal = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        return [part.flatten(0, 1) for part in (seen, actions, log_probs, normal, returns)]

    def _learn(self, seen: Tensor, actions: Tensor, old: Tensor, advantages: Tensor, returns: Tensor) -> None:
        """Take a step of the optimiser on a minibatch."""
        logits, values = self.network(seen)
        log_probs = F.log_softmax(logits, 1)
        ratio = (log_probs.gather(1, actions[:, None])[:, 0] - old).exp()
        clipped = ratio.clamp(1 - self.options.clip, 1 + self.options.clip)
        policy_loss = -torch.min(advantages * ratio, advantages * clipped).mean()
        value_loss = 0.5 * (values - returns).square().mean()
        entropy = -(log_probs.exp() * log_probs).sum(1).mean()
        self.optimizer.zero_grad()
        (policy_loss + value_loss - self.options.entropy * entropy).backward()
        nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self.optimizer.step()

    def state(self) -> dict[str, Any]:
        """All that the training needs to go on."""
        return {
            "steps": self.steps,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "games": self.games.state(),
            "random": self.random.getstate(),
            "torch": torch.get_rng_state(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a state."""
        self.steps = state["steps"]
        self.network.load_state_dict(state["network"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.games.restore(state["games"])
        self.random.setstate(state["random"])
        torch.set_rng_state(state["torch"])


def train(path: Path, options: Options) -> None:
    """Train in a run folder. At equal distances, the policy becomes an opponent, and the folder gets a checkpoint.

    A folder whose training was stopped goes on from its last checkpoint, and ends with the same weights.
    """
    torch.set_num_threads(1)
    exists = (path / "config.json").exists()
    with RunFolder.resume(path) if exists else RunFolder.begin(path, "self_play", TASK, asdict(options)) as run:
        if run.config["options"] != asdict(options):
            raise SystemExit(f"{path} has a training with {run.config['options']}; give the same --steps and --seed")
        learner, spent, due = Learner(options), np.zeros(2), 0.0
        pool: dict[int, ActorCritic] = {}
        if run.state is not None:
            spent, due, pool = np.array(run.state["minutes"]), run.state["due"], opponents(run)
            learner.restore(run.state)  # last: a new network draws random numbers
        before = spent - clocks()
        while learner.steps < options.steps or not pool:
            if pool:
                learner.update([*pool.values()])
            if learner.steps < min(due, options.steps):
                continue
            due += options.steps / options.checkpoints
            pool[learner.steps] = make_network()
            pool[learner.steps].load_state_dict(learner.network.state_dict())
            score, minutes = score_built_in(learner.network), before + clocks()
            row = {"step": learner.steps, "minutes": minutes[0], "processor_minutes": minutes[1], "built_in": score}
            run.log(row)
            weights = {step: network.state_dict() for step, network in pool.items()}
            state = learner.state() | {"pool": weights, "minutes": minutes.tolist(), "due": due}
            run.checkpoint(learner.steps, state, learner.network.state_dict())
            print("; ".join(f"{name} {number:,.10g}" for name, number in row.items()), flush=True)
        run.end("steps")


def opponents(run: RunFolder) -> dict[int, ActorCritic]:
    """The networks of the opponents by step, from the checkpoint of a folder that is resumed."""
    networks = {}
    for step, weights in ({} if run.state is None else run.state["pool"]).items():
        networks[step] = make_network()
        networks[step].load_state_dict(weights)
    return networks


def clocks() -> npt.NDArray[np.float64]:
    """Minutes by the clock on the wall, and of the processor."""
    return np.array([time.monotonic(), time.process_time()]) / 60


# Tests of strength


def score_built_in(network: ActorCritic, games: int = 32, max_frames: int = 18_000) -> float:
    """The mean score, -21 .. 21, in the one-player game, in which the cartridge plays the other side."""
    task = ALONE.replace(max_num_frames_per_episode=max_frames)
    envs = atari.AtariVectorEnv(task, games, autoreset_mode="Disabled", num_threads=1)
    sight, scores, over = Sight(envs.reset(seed=1_000_000)[0]), np.zeros(games), np.zeros(games, np.bool_)
    while not over.all():
        actions = INDICES[choose(network, sight.seen[:, 0]).numpy()]
        ram, rewards, terminations, truncations, _ = envs.step(actions)
        scores += np.where(over, 0, rewards)
        over |= terminations | truncations
        sight.push(ram)
    envs.close()
    return float(scores.mean())


def round_robin(networks: list[ActorCritic], games: int = 8, max_frames: int = 18_000) -> npt.NDArray[np.float64]:
    """Let each network play each other one, `games` games on either side, all at once.

    Returns:
        Entry i, j is the number of games that i has won against j, (n, n) float64. A draw is half a win of each.
    """
    count = len(networks)
    seats = np.array([(i, j) for i in range(count) for j in range(count) if i != j for _ in range(games)])
    task = TASK.replace(max_num_frames_per_episode=max_frames)
    envs = atari.AtariVectorEnv(task, len(seats), autoreset_mode="Disabled", num_threads=1)
    sight, points = Sight(envs.reset(seed=2_000_000)[0]), np.zeros(len(seats))
    over, actions = np.zeros(len(seats), np.bool_), np.zeros(seats.shape, np.int64)
    while not over.all():
        for index, network in enumerate(networks):
            mine = (seats == index) & ~over[:, None]
            if mine.any():
                actions[mine] = choose(network, sight.seen[mine]).numpy()
        ram, rewards, terminations, truncations, _ = envs.step(INDICES[actions])
        points += np.where(over, 0, rewards[:, 0] - rewards[:, 1])
        over |= (terminations | truncations).any(1)
        sight.push(ram)
    envs.close()
    wins = np.zeros((count, count))
    np.add.at(wins, (seats[:, 0], seats[:, 1]), (np.sign(points) + 1) / 2)
    np.add.at(wins, (seats[:, 1], seats[:, 0]), (1 - np.sign(points)) / 2)
    return wins


def load(folder: Path) -> tuple[list[int], list[ActorCritic]]:
    """Steps and networks of the opponents in a folder."""
    with RunFolder.resume(folder) as run:
        pool = opponents(run)
    if len(pool) < 2:
        raise SystemExit(f"{folder} has {len(pool)} checkpoints; make some with: self_play.py train {folder}")
    return [*pool], [*pool.values()]


def rank(folder: Path, games: int) -> list[int]:
    """Print the table of ratings, write `elo.csv`, and return the checkpoints' steps, the best first."""
    torch.manual_seed(0)
    torch.set_num_threads(1)
    steps, networks = load(folder)
    wins = round_robin(networks, games)
    ratings = elo_ratings(wins)
    order = np.argsort(-ratings.values)
    with (folder / "elo.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["steps", "elo", "error", "won", "games"])
        for i in order:
            row = (
                steps[i],
                round(ratings.values[i]),
                round(ratings.errors[i]),
                wins[i].sum(),
                wins[i].sum() + wins[:, i].sum(),
            )
            table.writerow(row)
            print("{:>10} steps   Elo {:>5} +- {:<3}  {:>6} of {:.0f} games won".format(*row))
    return [steps[i] for i in order]


# A match to watch


class Player:
    """One side of a `MultiplayerCore`: a network that chooses in every fourth frame."""

    def __init__(self, networks: list[ActorCritic]) -> None:
        self.networks, self.frame, self.actions = networks, 0, [0, 0]
        self.sight: Sight | None = None

    def __call__(self, core: MultiplayerCore) -> list[int]:
        """ALE's numbers of both players' actions for the next frame."""
        if self.frame % 4 == 0:
            ram = np.array(core.ram())[None]
            if self.sight is None:
                self.sight = Sight(ram)
            else:
                self.sight.push(ram)
            seen = self.sight.seen
            self.actions = [ACTIONS[int(choose(net, seen[:, side]))] for side, net in enumerate(self.networks)]
        self.frame += 1
        return self.actions


def match(folder: Path, frames: int, seed: int) -> list[int]:
    """Let the best two of `elo.csv` play, the best on the right, and return their points."""
    with (folder / "elo.csv").open(newline="") as file:
        best = [int(row["steps"]) for row in csv.DictReader(file)][:2]
    torch.manual_seed(seed)
    steps, networks = load(folder)
    sides = Player([networks[steps.index(one)] for one in best])
    core = MultiplayerCore("pong", mode=TASK.mode, seed=seed, repeat_action_probability=TASK.repeat_action_probability)
    with RecordReplay(core, folder / "best.a26r") as game:
        game.reset()
        while not (core.game_over or core.truncated) and sides.frame < frames:
            game.act_players(sides(core))
    points = [int(core.ram()[atari.games["pong"].ram_labels[name].index]) for name in ("score_player", "score_enemy")]
    print(f"{best[0]} steps on the right, {best[1]} on the left: {points[0]} to {points[1]} in {sides.frame} frames")
    Replay.load(folder / "best.a26r").render(folder / "best.mp4")
    return points


def main() -> None:
    """Run a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["train", "elo", "match"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--steps", type=float, default=Options.steps, help="train: steps of both players together")
    parser.add_argument("--seed", type=int, default=0, help="train, match")
    parser.add_argument("--games", type=int, default=8, help="elo: of each pair on either side")
    parser.add_argument("--frames", type=int, default=18_000, help="match: the most that are played")
    args = parser.parse_args()
    if args.command == "train":
        train(args.folder, Options(steps=int(args.steps), seed=args.seed))
    elif args.command == "elo":
        rank(args.folder, args.games)
    else:
        match(args.folder, args.frames, args.seed)


if __name__ == "__main__":
    main()
