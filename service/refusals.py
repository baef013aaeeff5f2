"""What a user is refused, with the number that HTTP has for it."""

from ..engine.errors import LumenrayError


class RefusalError(LumenrayError):
    """Something that the service does not do for a user.

    Parameters
    ----------
    code : int    Status of HTTP (RFC 9110, 15.5).
    text : str    One sentence for the user.
    """

    def __init__(self, code: int, text: str):
        super().__init__(text)
        self.code = code


def bad(text: str) -> RefusalError:
    """What was asked is not understood."""
    return RefusalError(400, text)


def missing(what: str) -> RefusalError:
    """There is no such thing of this user's; of others' nothing is said."""
    return RefusalError(404, f"there is no such {what}")


def conflict(text: str) -> RefusalError:
    """What was asked does not go with the state of things."""
    return RefusalError(409, text)
