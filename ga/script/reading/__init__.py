"""From text to the syntax tree.

`lexer` has the tokens, `expressions` the operators, `parser` statements and macros, `pragmas` the
pragmas, `syntax` the nodes of the tree.
"""
