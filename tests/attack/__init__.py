"""Attackers: each makes up hostile input for one part of the package, from a seed."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
