"""Checks of arguments, durable files, files of strangers, optional packages and programs, for every part."""
