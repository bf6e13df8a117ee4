"""Stages that say where the camera was: by boards, loose markers, SLAM, in metres and upright."""
