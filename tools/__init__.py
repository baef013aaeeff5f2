"""What makes the data of `libraries`: for developers, never in the zip, and imported by nothing of the product."""
