#!/usr/bin/env python3
"""Write published Atari results to atari/learning/evaluation/data: one JSON file for each source, one line a game.

usage: scripts/generate/published_scores.py FOLDER

FOLDER has `published/` (curves and tables of other projects, `sources.json` with their licences) and `benchmarks.json`
(sets of games, scores of papers). Scores, frames and seeds are taken over as they are. The protocols, which the sources
describe in words, are entered in the table PROTOCOLS below. Files are equal to the byte if the input is.
"""

import argparse
import csv
import json
from collections import defaultdict
from pathlib import Path
from typing import Any

OUTPUT = Path(__file__).parents[2] / "atari" / "learning" / "evaluation" / "data"


def facts(
    sticky: float | None,
    noops: tuple[int | None, int | None],
    actions: str | None,
    max_frames: int | None,
    phase: str,
    lives: str | None = "continue",
) -> dict[str, Any]:
    """The facts that must be equal to compare scores; None means not stated. All sources play four frames an action.

    `lives` is "fire" where FIRE is pressed after each lost life, else "continue"; one FIRE at the start does not count.
    """
    return {
        "repeat_action_probability": sticky,
        "noop_min": noops[0],
        "noop_max": noops[1],
        "full_action_space": None if actions is None else actions == "all",
        "frame_skip": 4,
        "max_frames": max_frames,
        "lives": lives,
        "phase": phase,
    }


NONE, BASELINES, DREAMER = (0, 0), (1, 30), (0, 30)
"""No-ops at the start of a game, (least, most). Baselines' wrapper and alewrap draw 1..30, DreamerV3 draws 0..30."""

BEST = "evaluation of the best network"
PROTOCOLS = {
    # rainbow.gin and others: sticky actions, epsilon 0.01 of the training, 27,000 steps; atari_lib.py: minimal actions
    "dopamine": facts(0.25, NONE, "minimal", 108_000, "training, epsilon 0.01"),
    # atari_lib.py with Gymnasium: max_num_frames_per_episode=100_000
    "dopamine_nets": facts(0.25, NONE, "minimal", 100_000, "training, epsilon 0.01"),
    # configs.yaml, env.atari and env.atari100k; atari.py: a limit of 108,000 frames, rng.integers(noops + 1)
    "dreamerv3/atari57": facts(0.25, DREAMER, "all", 108_000, "training"),
    "dreamerv3/atari100k": facts(0.0, DREAMER, "minimal", 108_000, "training, one to a few games a seed"),
    # only its scores are in the repository of DreamerV3
    "dreamerv3/atari57/muzero": facts(None, (None, None), None, None, "training", lives=None),
    # cleanba_ppo.py, cleanba_impala.py: EnvPool with noop_max=1, episodic_life=False, full_action_space=True
    "cleanba": facts(0.25, (1, 1), "all", 108_000, "training, the last 100 logged values"),
    # the wrappers of Baselines, or EnvPool with episodic_life=True, which presses FIRE after lost lives too
    "cleanrl": facts(0.0, BASELINES, "minimal", None, "training", lives="fire"),
    "cleanrl/ppo_rnd_envpool": facts(0.25, BASELINES, "minimal", None, "training", lives="fire"),
    "sb3_zoo": facts(0.0, BASELINES, "minimal", None, "evaluation of the last network, actions sampled", lives="fire"),
    # train_*.py, test=True: no episodic lives; wrap_deepmind has fire_reset=False; epsilon by agent
    "pfrl/dqn": facts(0.0, BASELINES, "minimal", 18_000, f"{BEST}, epsilon 0.05"),
    "pfrl/iqn": facts(0.0, BASELINES, "minimal", 108_000, f"{BEST}, epsilon 0.001"),
    "pfrl/rainbow": facts(0.0, BASELINES, "minimal", 108_000, BEST),
    "pfrl/a3c": facts(0.0, BASELINES, "minimal", 108_000, f"{BEST}, actions sampled"),
    "papers/dqn2015": facts(0.0, BASELINES, "minimal", 18_000, f"{BEST}, epsilon 0.05"),
    # Hessel et al. 2018: no-op starts, up to 30; "truncated at 108K frames (or 30 minutes of simulated play)"
    "papers/rainbow": facts(0.0, BASELINES, "minimal", 108_000, BEST),
    # the table of preprocessing in Badia et al. 2020 ("Never Give Up"), whose environments Agent57 has: action set full
    "papers/agent57": facts(0.0, (None, 30), "all", 108_000, "evaluation"),
}
"""By source, or by source and agent where agents differ; the comment above a line names where it was read."""

ALIASES = {
    "cleanrl/ppo": "cleanrl/ppo_atari_envpool_xla_jax",
    "cleanrl/dqn": "cleanrl/dqn_atari",
    "cleanrl/c51": "cleanrl/c51_atari",
    "cleanrl/rainbow": "cleanrl/rainbow_atari",
    "cleanrl/pqn": "cleanrl/pqn_atari_envpool",
    "dreamerv3/dreamerv3": "dreamerv3/atari57/dreamerv3",
    "dreamerv3/ppo": "dreamerv3/atari57/ppo",
    "dreamerv3/muzero": "dreamerv3/atari57/muzero",
}
"""Short names of agents; `cleanrl/ppo` has all 57 games."""

PFRL_FRAMES = {"a3c": 320_000_000}
SEEDS = {"cleanba": 3, "cleanrl": 3, "sb3_zoo": 1, "iqn": 3, "a3c": 3}
"""By source, by the first word of an agent, or by agent; other sources do not state them, or state two numbers."""

PAPERS = {
    "dqn2015": ("DQN (Mnih et al. 2015)", "dqn_nature_2015", 200_000_000),
    "rainbow": ("Rainbow (Hessel et al. 2018)", "rainbow", 200_000_000),
    "agent57": ("Agent57 (Badia et al. 2020)", "agent57", None),
}


CURVES = ("mean", "std", "marks", "final")
"""The numbers of a game in a file with learning curves."""


def main() -> None:
    """Write the files and print their sizes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    folder = parser.parse_args().folder
    published = folder / "published"
    sources = read(published / "sources.json")
    benchmarks = read(folder / "benchmarks.json")
    files = {
        "dopamine": curves(published / "dopamine.json"),
        "dopamine_nets": curves(published / "dopamine_nets.json"),
        "dreamerv3": curves(published / "dreamerv3.json"),
        "cleanba": table(published / "cleanba.csv", 200_000_000),
        "cleanrl": table(published / "cleanrl.csv", 40_000_000),
        "sb3_zoo": table(published / "sb3_zoo.csv", 40_000_000),
        "pfrl": table(published / "pfrl.csv", 200_000_000),
        "papers": papers(benchmarks),
    }
    for name, agents in files.items():
        for agent, entry in agents.items():
            keys = (f"{name}/{agent}", f"{name}/{agent.split('/')[0]}", name)
            entry["protocol"] = next(PROTOCOLS[key] for key in keys if key in PROTOCOLS)
        write(name, agents)
    write("human", human(published / "human_random.json"))
    write(
        "sources", {name: provenance(entry) for name, entry in sources.items()} | {"papers": papers_source(benchmarks)}
    )
    write("index", {"aliases": ALIASES, "agents": {name: list(agents) for name, agents in files.items()}})
    suites = {name.replace("_", "").replace("nature", "atari"): suite for name, suite in benchmarks["suites"].items()}
    suites["atari5"] = benchmarks["atari_5"]["subsets"]["atari_5"]
    write("atari5", suites["atari5"]["coefficients"])
    write("sets", {name: sorted(suite["games"]) for name, suite in suites.items()})


def read(file: Path) -> Any:
    """The content of a JSON file."""
    return json.loads(file.read_text(encoding="utf-8"))


def write(name: str, content: Any) -> None:
    """Write a file, sorted, with the numbers of a game on one line, so that a change of a score is one line."""
    text = laid_out(content)
    (OUTPUT / f"{name}.json").write_text(f"{text}\n", encoding="utf-8")
    print(f"{name}: {len(text):,} characters")


def laid_out(content: Any, margin: str = "") -> str:
    """JSON with an item of each mapping, and of each list of texts, on a line of its own; all else is on one line."""
    inner = f"{margin} "
    if isinstance(content, dict) and not content.keys() <= {"score", *CURVES}:
        lines = [f"{inner}{json.dumps(key)}: {laid_out(content[key], inner)}" for key in sorted(content)]
        return "{\n" + ",\n".join(lines) + f"\n{margin}}}"
    if isinstance(content, list) and content and all(isinstance(item, str) for item in content):
        return "[\n" + ",\n".join(f"{inner}{laid_out(item)}" for item in content) + f"\n{margin}]"
    return json.dumps(content, separators=(",", ":"), ensure_ascii=False, sort_keys=True)


def curves(file: Path) -> dict[str, Any]:
    """The agents of a file with learning curves."""
    content = read(file)
    agents = {}
    for agent, games in content["data"].items():
        frames = content.get("frames") or content[f"frames_{agent.split('/')[0]}"]
        entry: dict[str, Any] = {"title": content["agents"][agent], "frames": frames, "games": {}}
        if any("marks" in game for game in games.values()):
            entry["marks"] = content["marks"]
        for game, data in games.items():
            entry["games"][game] = {key: data[key] for key in CURVES if data.get(key)}
        agents[agent] = entry
    return agents


def table(file: Path, frames: int) -> dict[str, Any]:
    """The agents of a file with final scores; each score is a mean over seeds."""
    agents: dict[str, Any] = defaultdict(lambda: {"games": {}})
    with file.open(encoding="utf-8", newline="") as rows:
        for row in csv.DictReader(rows):
            entry, agent = agents[row["agent"]], row["agent"]
            if not row["score"]:
                continue
            steps = row.get("agent_steps")
            entry["title"] = agent
            entry["final_frames"] = 4 * int(steps) if steps else PFRL_FRAMES.get(agent, frames)
            stated = row.get("seeds")
            keys = (agent, agent.split("_")[0], "sb3_zoo" if file.stem == "sb3_zoo" else "")
            entry["seeds"] = int(stated) if stated else next((SEEDS[key] for key in keys if key in SEEDS), None)
            entry["games"][row["game"]] = {"score": float(row["score"])}
    return dict(agents)


def papers(benchmarks: dict[str, Any]) -> dict[str, Any]:
    """The columns of scores that papers print."""
    return {
        name: {
            "title": title,
            "final_frames": frames,
            "seeds": None,
            "games": {
                game["rom_id"]: {"score": game[column]} for game in benchmarks["games"] if game.get(column) is not None
            },
        }
        for name, (title, column, frames) in PAPERS.items()
    }


def papers_source(benchmarks: dict[str, Any]) -> dict[str, Any]:
    """The sources of the columns of papers."""
    return {
        "repo": "seungjaeryanlee/rldb; arXiv 2003.13350",
        "commit": benchmarks["sources"]["rldb"]["commit"],
        "licence": "figures printed in papers",
        "copyright": "none claimed: facts",
        "notes": [benchmarks["score_columns"][column]["meaning"] for _, column, _ in PAPERS.values()],
        "score": "evaluation, whole games, not clipped",
    }


def provenance(entry: dict[str, Any]) -> dict[str, Any]:
    """The part of a source that is kept: its place, its licence, and the meaning of its scores."""
    kept = {key: entry[key] for key in ("repo", "commit", "licence", "copyright", "paths", "notes") if key in entry}
    protocol = entry.get("protocol") or {}
    return kept | {
        "score": "; ".join(str(protocol[key]) for key in ("score", "phase", "evaluated_at") if key in protocol)
    }


def human(file: Path) -> dict[str, Any]:
    """The tables of human and random scores, by table and game, and the differences between copies of them."""
    content = read(file)
    tables: dict[str, Any] = {name: {**table, "games": {}} for name, table in content["tables"].items()}
    for game, entries in content["games"].items():
        for name, pair in entries.items():
            tables[name]["games"][game] = pair
    return {"tables": tables, "sources": content["sources"], "which_table": content["which_table"]}


if __name__ == "__main__":
    main()
