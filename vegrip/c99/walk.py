"""All nodes of a syntax tree, found once: the translator asks for them again and again."""

import ast


def nodes_of(tree: ast.AST) -> tuple[ast.AST, ...]:
    """Return ``tree`` and everything below it; the tree must not change from then on."""
    try:
        known: tuple[ast.AST, ...] = tree.__dict__["nodes_found"]
    except KeyError:
        known = tree.__dict__["nodes_found"] = tuple(ast.walk(tree))
    return known
