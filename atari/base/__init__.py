"""What every part uses: checks of arguments, durable files, files of strangers, optional packages, and programs."""
