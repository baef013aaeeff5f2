"""The selection of a view layer."""


def select_only(view_layer, things) -> None:
    """Select objects that a view layer shows, and no others; the last becomes the active one."""
    # First, because it makes Blender see what was linked just now: copies are selected as their originals are.
    for each in things:
        each.select_set(True, view_layer=view_layer)
    for each in set(view_layer.objects.selected) - set(things):
        each.select_set(False, view_layer=view_layer)
    view_layer.objects.active = things[-1]
