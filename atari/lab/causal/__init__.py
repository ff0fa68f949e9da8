"""The causal map: what each byte of a game's RAM causes, found by changing it in forks beside an unchanged twin.

`explore.py` plays a game and its forks in C++ (`emulator/lab/`), `map.py` has the result, `fit.py` the suggestions,
`picture.py` draws a map, and `data/` has the essence of the maps of all games.
"""

from atari.lab.causal.explore import causes
from atari.lab.causal.files import shipped_causes
from atari.lab.causal.map import ByteCauses, CausalMap
from atari.lab.causal.suggestion import Suggestion

__all__ = ["ByteCauses", "CausalMap", "Suggestion", "causes", "shipped_causes"]
