"""Small files of text."""


def written(folder, content, name="spectrum.txt"):
    """Write text, bytes or rows of text, and return the path."""
    path = folder / name
    if not isinstance(content, str | bytes):
        content = "\n".join(content) + "\n"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path
