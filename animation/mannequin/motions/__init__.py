"""The mannequin's clips, made from curves of the phase and inverse kinematics of the legs."""
