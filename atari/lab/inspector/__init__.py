"""The inspector: a session with a game whose RAM is seen, searched and changed, and the local page that shows it.

`session.py` has what can be done, without a page; `server.py` serves the page; `protocol.py` is what they send each
other.
"""
