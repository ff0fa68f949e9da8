"""Copies of cores by `pickle` and `copy`: a new core of the same arguments continues from a snapshot."""

from typing import Any

from atari.cores import writes


def save(core: Any) -> dict[str, Any]:
    """The arguments of a core, the writes of `Freeze` and `Poke`, and a snapshot.

    Raises:
        RuntimeError: see the core's `snapshot`.
    """
    slots = writes.definitions(writes.slots(core))
    return {"arguments": core._arguments(), "writes": slots, "snapshot": core.snapshot()}


def load(core: Any, saved: dict[str, Any]) -> None:
    """Make a core, whose class has only allocated it, continue from a result of `save`."""
    core.__init__(**saved["arguments"])
    writes.restore(core, saved["writes"])
    core.restore(saved["snapshot"])
