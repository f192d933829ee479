"""The source paper, J. Vib. Control, doi 10.1177/10775463261460015: its figures redrawn, its claims checked.

`presets` holds the parameter sets, `studies` compute, `figures` draw the studies, `claims` check them, `verdicts` holds
the rules of judgement, `run` computes, draws and caches, and `report` writes an HTML page.
"""
