"""The value of a RAM label as an expression of its byte."""

from atari.games.game import RamLabel


def value_source(label: RamLabel) -> str:
    """The value of a label as an expression over `v`, its byte, and `ram[0..127]`.

    It is the label's `transform`; without one, the two decimal digits of a byte encoded as "bcd", else the bits of its
    mask. A `weight` multiplies it, so that a byte of a score counts in points.
    """
    if label.transform is not None:
        value = label.transform
    else:
        bits = "v" if label.mask is None else f"(v & {label.mask})"
        value = f"10 * ({bits} >> 4) + ({bits} & 15)" if label.encoding == "bcd" else bits
    return value if label.weight in (None, 1) else f"({value}) * {label.weight}"
