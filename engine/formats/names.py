"""Names of files."""

import re


def file_stem(name: str) -> str:
    """Turn an object's name into a file name that every system takes."""
    return re.sub(r"[^\w\-. ]", "_", name).strip(" .").replace(" ", "_") or "object"
