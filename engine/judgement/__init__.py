"""Whether lighting does what is required: requirements as data (`reader` is the door), and verdicts with errors."""
