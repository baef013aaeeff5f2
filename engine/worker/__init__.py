"""The engine in a process of its own: how it is started, spoken to and watched."""
