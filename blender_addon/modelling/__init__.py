"""What of a scene is modelled: the user's switches, and the decisions that the engine makes of them."""
