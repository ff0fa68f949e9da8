"""The recorder of videos, in Gym's place."""
