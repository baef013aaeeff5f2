"""Which node trees and images a data-block's shading reads."""


def shading_dependencies(block) -> frozenset[int]:
    """Return session uids of all node trees and images behind a material, world or light, groups included."""
    found: set[int] = set()
    images: set[int] = set()
    waiting = [block.node_tree] if block.node_tree is not None else []
    while waiting:
        tree = waiting.pop()
        if tree.session_uid in found:
            continue
        found.add(tree.session_uid)
        for node in tree.nodes:
            group = getattr(node, "node_tree", None)
            if group is not None:
                waiting.append(group)
            image = getattr(node, "image", None)
            if image is not None:
                images.add(image.session_uid)
    return frozenset(found | images)
