"""The service under load: users who ask and edit, a long queue, and ends of the service in between."""
