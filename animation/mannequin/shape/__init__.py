"""The mannequin's surface: signed distances, the mesh of their zero, its weights and colours."""
