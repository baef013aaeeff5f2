"""The command ``lumenray daylight``: the daylight of a year at sensors; its door is `command`."""
