"""The whole run: clips described, stages in their order, results, the report, runs read back.

`job` lists the stages and runs them on a recording.
"""
