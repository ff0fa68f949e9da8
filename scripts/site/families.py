"""The table of the families of environment IDs, from the package's own table."""

from atari.env_ids import FAMILIES, Family


def _skip(frameskip: int | tuple[int, int]) -> str:
    if isinstance(frameskip, tuple):
        return f"{frameskip[0]} to {frameskip[1] - 1}, random"
    return str(frameskip)


def _row(family: Family) -> str:
    observation = "RAM, (128,)" if family.obs_type == "ram" else "RGB, (210, 160, 3)"
    sticky = family.repeat_action_probability or "no"
    cells = (f"`{family.id('pong')}`", observation, _skip(family.frameskip), str(sticky), str(len(family.games())))
    return f"| {' | '.join(cells)} |"


def table() -> str:
    """A row for each family, with Pong's ID."""
    head = ["| ID of Pong | observation | frames a step | sticky actions | games |", "|---|---|---|---|---|"]
    return "\n".join([*head, *map(_row, FAMILIES)])
