"""The RAM lab: values by name, search, interventions and causes of the 128 bytes of RAM. `docs/ram.md` explains it."""

from atari.lab.causal import CausalMap, causes, shipped_causes
from atari.lab.collect import write_dataset
from atari.lab.objects import GameObject
from atari.lab.ram import Ram
from atari.lab.ram_labels import RamLabels
from atari.lab.search import Search
from atari.lab.watch import Watch, WatchVector
from atari.lab.widget import show
from atari.lab.writes import Freeze, Poke

__all__ = [
    "CausalMap",
    "Freeze",
    "GameObject",
    "Poke",
    "Ram",
    "RamLabels",
    "Search",
    "Watch",
    "WatchVector",
    "causes",
    "shipped_causes",
    "show",
    "write_dataset",
]
