"""Sweeps: trainings of one agent in several games with several seeds, each in a process and a run folder of its own.

`plan` makes the runs and checks the folder, `processes` does them, `table` shows them, `results` compares them with
published agents, and `report` writes a page.
"""
