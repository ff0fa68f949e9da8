"""What the encoder of a trained agent has kept of the game's state, beside two baselines.

    atari train ppo pong --games 0 --fast --total-steps 150000 -o runs/probed
    python examples/probe_encoder.py runs/probed

Prints the F1 score of each of AtariARI's categories for the trained encoder, the same network with random weights, the
pixels of the newest frame, and the most frequent value. Needs the extra `learn`.
"""

import argparse
from pathlib import Path

import numpy as np
import torch

from atari.lab.probes import majority, play_episodes, probe, split_episodes
from atari.lab.probes.probe import ProbeResult
from atari.learning.agent import kept_agent, read_options
from atari.learning.run_folder import RunFolder


def main() -> None:
    """Probe the encoder of a run folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="a run folder of `atari train`, from pixels")
    parser.add_argument("--states", type=int, default=16_000, help="states that a random player visits")
    parser.add_argument("--epochs", type=int, default=100, help="most epochs of a probe")
    args = parser.parse_args()
    torch.set_num_threads(1)

    folder = RunFolder.open(args.run)
    options = read_options(folder)
    task = options.task
    if task.stack_num is None or task.img_height is None or task.img_width is None:
        raise SystemExit(f"{args.run} is a training from RAM; probe one from images")
    screen = {"stack_num": task.stack_num, "img_height": task.img_height, "img_width": task.img_width}
    shape = tuple(screen.values())
    agent = kept_agent(folder).kind
    networks = []
    for _ in range(2):
        torch.manual_seed(0)
        networks.append(agent.make_network(options, shape, len(task.action_set)))
    networks[0].load_state_dict(folder.load_weights())

    data = split_episodes(play_episodes(task.game, args.states, **screen), task.game)
    print(
        f"{len(data.train)} states of training, {len(data.validation)} of validation, {len(data.test)} of the test",
        flush=True,
    )
    print(f"labels: {', '.join(data.names)}\n")
    encoders = {
        "trained": lambda seen: networks[0].encoder(torch.from_numpy(seen)),
        "random weights": lambda seen: networks[1].encoder(torch.from_numpy(seen)),
        "pixels": lambda seen: seen[:, -1] / np.float32(255),
    }
    show("most frequent", majority(data))
    for name, encoder in encoders.items():
        show(name, probe(encoder, data, epochs=args.epochs))


def show(name: str, result: ProbeResult) -> None:
    """Print the F1 scores of an encoder."""
    scores = ", ".join(f"{category} {score:.3f}" for category, score in result.category_f1.items())
    print(f"{name}: {scores}; mean {result.mean_f1:.3f}", flush=True)


if __name__ == "__main__":
    main()
