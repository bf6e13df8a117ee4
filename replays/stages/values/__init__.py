"""What the stages of the pipeline take and give: frozen values, apart from the functions.

A module here imports no stage, so that the key of a cached result covers the code that made it and
no more. Poses are ``world_T_camera``; units end the names.
"""
