"""Readers of recordings, one module a layout; each gives a `replays.io.recording.Recording`.

Files of a recording are untrusted: a name in them may not lead outside the recording's folder,
sizes are bounded before anything is read, and whatever does not fit is a `RecordingError`.

`columns.read_columns` reads named columns with units (IMU, poses), `tables.read_table` numbers
alone, `tables.read_listing` stamps with files' names; `calibration.make_camera` checks intrinsics.
"""
