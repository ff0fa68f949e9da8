"""The causal map: the effects of each byte of a game's RAM, found by changing it in forks beside an unchanged twin.

`explore.py` plays a game and its forks in C++ (`emulator/lab/`), `map.py` has the result, `fit.py` the suggestions,
`picture.py` draws a map, and `data/` has the essence of the maps of all games. `atari.lab` has the functions.
"""
