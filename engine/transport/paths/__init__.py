"""Light along paths from the receiver: the path loop, and what is asked of it at sensors and in pictures."""
