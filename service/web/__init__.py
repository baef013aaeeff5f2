"""What the service says over HTTP: `server` is the door, `app` lists the routes."""
