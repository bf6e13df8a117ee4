"""Compressed data of glTF files, brought back to the plain arrays that accessors describe."""
