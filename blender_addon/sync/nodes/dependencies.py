"""Which node trees and images a data-block's shading reads."""

DEEPEST = 16
"""Groups within each other that are looked into."""


def nodes_of(tree, depth: int = 0):
    """Yield the nodes of a tree, and those of groups within it."""
    for node in tree.nodes:
        yield node
        if node.type == "GROUP" and node.node_tree is not None and depth < DEEPEST:
            yield from nodes_of(node.node_tree, depth + 1)


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
