"""The commands ``lumenray cluster …``: the processes that a cluster is made of."""
