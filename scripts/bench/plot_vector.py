#!/usr/bin/env python
"""Draws the steps a second of vector environments, over the number of environments.

    scripts/bench.py --suite sizes --json sizes.json
    scripts/bench/plot_vector.py sizes.json docs/vector-throughput.svg

Steps are summed over all environments. A step has four frames and an 84x84 observation, unless the legend says RAM. For
several games, the plot has geometric means. It needs matplotlib.
"""

import argparse
import json
import statistics
from pathlib import Path
from typing import Any

Curve = list[tuple[int, float]]
"""(environments, steps a second)"""


def curves(document: dict[str, Any]) -> dict[str, Curve]:
    """By contestant, its steps a second by number of environments."""
    by_name: dict[str, dict[int, list[float]]] = {}
    for comparisons in document["results"].values():
        for title, times in comparisons.items():
            count = int(title.split()[0])
            for name, values in times.items():
                speeds = by_name.setdefault(name, {}).setdefault(count, [])
                speeds.append(1e6 / statistics.median(values))
    return {
        name: [(count, statistics.geometric_mean(speeds)) for count, speeds in sorted(by_count.items())]
        for name, by_count in by_name.items()
    }


def subtitle(document: dict[str, Any]) -> str:
    """The subtitle: the games, the machine, and the versions of the packages."""
    machine, versions = document["machine"], document["versions"]
    peers = ", ".join(f"{name} {versions[name]}" for name in ("atari-envs", "ale-py", "envpool") if name in versions)
    return f"{', '.join(document['results'])}; {machine['processor']}, {machine['cores']} threads\n{peers}"


def draw(document: dict[str, Any], path: Path) -> None:
    """Write the plot; the name's ending selects the format."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "vector"  # the same numbers make the same file
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 4.5), layout="constrained")
    for name, points in curves(document).items():
        style = {"marker": "o", "linewidth": 2} if name.startswith("native") else {"marker": "s", "linestyle": "--"}
        axes.plot(*zip(*points, strict=True), label=name, **style)
    counts = sorted({count for points in curves(document).values() for count, _ in points})
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:,.0f}"))
    axes.set(xlabel="environments", ylabel="steps a second")
    axes.set_title(subtitle(document), fontsize="small", loc="left")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def main() -> None:
    """Parse the options and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("json", type=Path, help="what bench.py --suite sizes --json wrote")
    parser.add_argument("plot", type=Path, help="file to write, .svg or .png")
    options = parser.parse_args()
    document = json.loads(options.json.read_text())
    if document.get("suite") != "sizes":
        parser.error(f"{options.json} is of suite {document.get('suite')!r}; run bench.py --suite sizes --json FILE")
    try:
        draw(document, options.plot)
    except ImportError as error:
        parser.error(f"{error}: pip install matplotlib")


if __name__ == "__main__":
    main()
