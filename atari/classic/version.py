"""The version of Gym whose interface this package has, for scripts that check it."""

VERSION = "0.21.0"
"""The last version of Gym with this interface."""
