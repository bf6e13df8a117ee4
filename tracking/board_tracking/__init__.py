"""A board followed through a recording: corners carried along, poses chosen, the path kept."""
