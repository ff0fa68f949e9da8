"""`Suggestion`: the probable meaning of a byte of RAM, by the effects of its changes."""

from dataclasses import dataclass

POSITIONS = ("position_x", "position_y")


@dataclass(frozen=True)
class Suggestion:
    """The probable meaning of a byte of RAM.

    `index` is the byte, 0..127. `kind` is "position_x", "position_y", "score" or "lives", like the kind of a label in a
    game definition. `transform` is an expression over the byte `v`: the column or row of the left or upper edge of the
    thing that moves, or None. `support` is the number of forks that agree or not, and `share` the part of them that
    agree, 0..1. `width` and `height` are the size of the moving thing, in pixels, and None for the other kinds.
    `weight` is the worth of one unit of a score byte, and `encoding` "bcd" or "plain".
    """

    index: int
    kind: str
    support: int
    share: float
    transform: str | None = None
    width: int | None = None
    height: int | None = None
    weight: int | None = None
    encoding: str | None = None

    def __str__(self) -> str:
        agree = f"({self.share:.0%} of {self.support} forks)"
        place = f"${0x80 + self.index:02X} {self.index}"
        if self.transform is not None:
            return f"{place}: {self.kind[-1]} = {self.transform}, {self.width} x {self.height} pixels {agree}"
        if self.weight is not None:
            return f"{place}: {self.kind}, {self.encoding}, unit {self.weight} {agree}"
        return f"{place}: {self.kind} {agree}"

    def label(self) -> str:
        """The suggestion as a value of the table `[ram]` of a game definition, in TOML."""
        facts = [f"index = {self.index}", f'kind = "{self.kind}"']
        if self.encoding is not None:
            facts.append(f'encoding = "{self.encoding}"')
        if self.weight is not None:
            facts.append(f"weight = {self.weight}")
        if self.transform is not None:
            facts.append(f'transform = "{self.transform}"')
        facts += ['sources = ["measured"]', f'evidence = "causal map: {self.share:.0%} of {self.support} forks"']
        return "{" + ", ".join(facts) + "}"
