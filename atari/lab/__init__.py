"""The RAM lab: values by name, search, interventions and causes of the 128 bytes of RAM. `docs/ram.md` explains it."""

from atari.lab.causal.explore import causes
from atari.lab.causal.files import shipped_causes
from atari.lab.dataset import write_dataset
from atari.lab.dataset_check import check_dataset
from atari.lab.dataset_reader import read_dataset
from atari.lab.ram import Ram
from atari.lab.ram_labels import RamLabels
from atari.lab.search import Search
from atari.lab.starts import spread
from atari.lab.watch import Watch
from atari.lab.widget import show
from atari.lab.writes import Freeze, Poke

__all__ = [
    "Freeze",
    "Poke",
    "Ram",
    "RamLabels",
    "Search",
    "Watch",
    "causes",
    "check_dataset",
    "read_dataset",
    "shipped_causes",
    "show",
    "spread",
    "write_dataset",
]
