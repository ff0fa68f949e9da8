"""The inspector: a game whose RAM is seen, searched and changed, and the local page that shows it.

`inspection.py` has all actions of a user, without a page; `server.py` serves the page; `protocol.py` has the messages.
"""
