"""From text to the syntax tree.

`lexer` has the tokens, `expressions` the operators, `parser` statements, macros and
pragmas, `syntax` the nodes of the tree.
"""
