"""Of what pictures are made: the marks of shapes, and the ground that they stand on."""
