"""The inspector: a session with a game whose RAM is seen, searched and changed, and the local page that shows it.

`session.py` has all actions of a user, without a page; `server.py` serves the page; `protocol.py` has their messages.
"""
