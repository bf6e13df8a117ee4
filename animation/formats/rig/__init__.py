"""What a file says about a character before it becomes one, and the way there.

Readers fill in a `Rig` (`values`): nodes with local transforms of any scale, surfaces, clips as
functions of time, axes and unit of the file. `assemble_character` (`assemble`) turns it into a
character in metres whose joint frames are rigid.
"""
