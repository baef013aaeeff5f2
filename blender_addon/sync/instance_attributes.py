"""Attributes that geometry nodes give to the instances that they make."""

import numpy as np

from .meshes import read_values
from .visibility import NO_ID

KINDS = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int32, 1),
    "BOOLEAN": ("value", np.bool_, 1),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
}
"""Types of attributes that Cycles hands to materials: property, type of number, channels."""

REFERENCE = ".reference_index"
"""Attribute of instances that says which of the references each shows."""


class InstanceAttributes:
    """Attributes of the instances of one walk; each is read once."""

    def __init__(self):
        self._geometries: dict[int, object] = {}
        self._values: dict[tuple, np.ndarray | None] = {}

    def find(self, name: str, instance, parent) -> tuple | None:
        """Return an attribute of an instance, the innermost where instances lie in others; None if it has none.

        Parameters
        ----------
        name : str
        instance : bpy.types.DepsgraphObjectInstance
        parent : bpy.types.Object    Evaluated; makes the instance.

        Raises
        ------
        LookupError    This version of Blender does not tell.
        """
        if not hasattr(parent, "evaluated_geometry"):
            raise LookupError(name)
        uid = parent.original.session_uid
        if uid not in self._geometries:
            self._geometries[uid] = parent.evaluated_geometry()
        geometry, place, found = self._geometries[uid], (uid,), None
        numbers = [number for number in instance.persistent_id if number != NO_ID]
        for number in reversed(numbers):
            instances = geometry.instances_pointcloud()
            if instances is None:
                break
            values = self._read(place, name, instances)
            if values is not None and number < len(values):
                found = tuple(float(each) for each in values[number])
            references = self._read(place, REFERENCE, instances)
            if references is None or number >= len(references):
                break
            shown = geometry.instance_references()[int(references[number, 0])]
            if not hasattr(shown, "instances_pointcloud"):
                break
            geometry, place = shown, (*place, number)
        return found

    def _read(self, place: tuple, name: str, instances) -> np.ndarray | None:
        key = (*place, name)
        if key not in self._values:
            attribute = instances.attributes.get(name)
            kind = None if attribute is None else KINDS.get(attribute.data_type)
            self._values[key] = (
                None
                if kind is None
                else read_values(attribute.data, *kind[:2], (len(attribute.data), kind[2]))
            )
        return self._values[key]
