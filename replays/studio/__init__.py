"""The local server of `motorcade author`: who may come in, what is served, scenes edited together.

It needs the extra `[studio]` (Starlette, uvicorn, websockets, segno, cryptography).
"""
