"""Light followed from the lights to where it lands, where paths from the receiver would not find it."""
