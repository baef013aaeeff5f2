"""The mouse in Blender's window, moved by xdotool, which waits for what Blender says of it rather than for time to pass.

Blender reads the mouse when it comes to it, and what it last saw of a handle is as old as the last drawing. So the 3D view
is drawn anew all the time, and what has not been heard is done again.
"""

import subprocess

import window
from window import module, wait_for

HEARD = 60.0
"""How long Blender may take to hear of what the mouse does. [s]"""

AGAIN, PRESSED_AGAIN = 0.5, 5.0
"""After which time it is done again: to move once more does no harm, to press a button once more may. [s]"""

STEPS = 15
"""Of a drag."""


def do(*words) -> None:
    """Have xdotool do something."""
    subprocess.run(["xdotool", *map(str, words)], check=True)


class Handle:
    """What Blender knows of a handle (a gizmo), as of the last drawing.

    Parameters
    ----------
    group : type    Its group, which has it as an attribute.
    name : str    Of that.
    """

    def __init__(self, group, name: str):
        self.is_hit = self.is_dragged = False
        prepare = group.draw_prepare

        def watch(own, context):
            prepare(own, context)
            gizmo = getattr(own, name)
            self.is_hit, self.is_dragged = gizmo.is_highlight, gizmo.is_modal

        group.draw_prepare = watch


class Listener:
    """What an operator has heard of the mouse while it ran.

    ``places``: how many places it has been told; ``mouse``: where it saw the mouse last, from the upper left corner. [pixel]
    """

    def __init__(self, operator):
        self.is_running, self.places, self.mouse = False, 0, None
        modal = operator.modal

        def listen(own, context, event):
            result = modal(own, context, event)
            self.is_running = "RUNNING_MODAL" in result or "PASS_THROUGH" in result
            self.places = len(getattr(own, "places", ()))
            self.mouse = event.mouse_x, window.window().height - event.mouse_y
            return result

        operator.modal = listen

    def is_at(self, place) -> bool:
        """Whether it saw the mouse there; what is dragged may lie half a pixel beside."""
        return (
            self.mouse is not None
            and max(abs(own - other) for own, other in zip(self.mouse, place, strict=True)) <= 1
        )


def repeat_until(condition, act, what, again=AGAIN):
    """Do something again and again until a condition holds.

    Raises
    ------
    TimeoutError    It did not come to hold.
    """

    def is_met():
        window.redraw()
        return condition()

    for _ in range(int(HEARD / again)):
        act()
        try:
            return (yield from wait_for(is_met, what, again))
        except TimeoutError:
            continue
    raise TimeoutError(f"{what}: not within {HEARD:.0f} s")


def move(place, condition, what):
    """Move to a place until a condition holds; nudged, as a mouse that does not move says nothing."""
    nudge = [0]

    def act():
        nudge[0] = 1 - nudge[0]
        do("mousemove", place[0] + nudge[0], place[1])
        do("mousemove", *place)

    return (yield from repeat_until(condition, act, what))


def press(condition, what):
    """Press the button until a condition holds: what the first press did not reach is let go before the next."""
    is_down = [False]

    def act():
        if is_down[0]:
            do("mouseup", 1)
        do("mousedown", 1)
        is_down[0] = True

    return (yield from repeat_until(condition, act, what, PRESSED_AGAIN))


def drag_to(start, end, is_there, what):
    """Move with the button down, step by step, until a condition holds."""
    for i in range(1, STEPS + 1):
        place = [round(a + (b - a) * i / STEPS) for a, b in zip(start, end, strict=True)]
        do("mousemove", *place)
        window.redraw()
        yield window.TICK
    return (yield from move(end, is_there, what))


def release(condition, what):
    """Let the button go, and wait until a condition holds."""
    do("mouseup", 1)
    return (yield from repeat_until(condition, window.redraw, what))


def drag_handle(handle: Handle, start, end, read, picture=None):
    """Drag a handle from place to place; what it stands for has to change and to stand still.

    Parameters
    ----------
    read : callable    What it stands for.
    picture : Path or None    Where the screen is shown with the button still down.
    """
    yield from move(start, lambda: handle.is_hit, "the handle under the mouse")
    yield from press(lambda: handle.is_dragged, "the handle held by the mouse")
    state = {"begin": read(), "last": None, "still": 0}

    def is_there():
        value = read()
        state["still"] = state["still"] + 1 if value == state["last"] else 0
        state["last"] = value
        return value != state["begin"] and state["still"] > 4

    yield from drag_to(start, end, is_there, "what the handle stands for")
    if picture is not None:
        window.take_picture(picture)
    yield from release(lambda: not handle.is_dragged, "the handle let go")


def handle_of(name: str, attribute: str) -> Handle:
    """Watch a handle of our extension by the name of its group in `ui.ground_overlay`."""
    return Handle(getattr(module("ui.ground_overlay"), name), attribute)
