"""Random expressions of rewards for Hypothesis."""

from functools import cache

from hypothesis import strategies as st

import atari

_OPERATORS = "+ - * / // % & | ^ << >> == != < <= > >= and or".split()


def names(game: str) -> st.SearchStrategy[str]:
    """A name of a game's reward, or a number of RAM."""
    labels = list(atari.games[game].ram_labels)
    address = st.integers(0x80, 0xFF).map(hex)
    ranges = st.tuples(st.integers(0x80, 0xF0), st.integers(0, 15)).map(lambda pair: (pair[0], sum(pair)))
    return st.one_of(
        st.sampled_from(["reward", "lives", "lives_lost", *labels]),
        address.map("ram[{}]".format),
        address.map("s8(ram[{}])".format),
        st.lists(address, min_size=1, max_size=3).map(lambda given: f"bcd({', '.join(given)})"),
        st.tuples(st.sampled_from(["same", "pos_sum", "neg_sum"]), ranges).map(lambda one: f"{one[0]}{one[1]}"),
        ranges.map(lambda one: f"count({one[0]}, {one[1]}, 0, 255)"),
    )


@cache
def expressions(game: str) -> st.SearchStrategy[str]:
    """An expression of the whole language, with parentheses around each part."""
    name = names(game)
    labels = st.sampled_from([label for label in atari.games[game].ram_labels if label != "lives"])
    leaves = st.one_of(
        st.sampled_from(["0", "1", "2", "0.1", "0.5", "7", "31", "255", "1e9", "3e38", "1e-300"]),
        name,
        name.map("before.{}".format),
        labels.map("visible({})".format),
        labels.map("visible(before.{})".format),
    )

    def deeper(parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return st.one_of(
            st.tuples(parts, st.sampled_from(_OPERATORS), parts).map(lambda one: f"({' '.join(one)})"),
            st.tuples(st.sampled_from(["-", "~", "not "]), parts).map(lambda one: f"({one[0]}{one[1]})"),
            st.tuples(parts, parts, parts).map(lambda one: f"({one[0]} if {one[1]} else {one[2]})"),
            st.tuples(parts, parts, parts).map(lambda one: f"({one[0]} < {one[1]} <= {one[2]})"),
            st.tuples(st.sampled_from(["min", "max"]), parts, parts).map(lambda one: f"{one[0]}({one[1]}, {one[2]})"),
            parts.map("abs({})".format),
        )

    return st.recursive(leaves, deeper, max_leaves=12)
