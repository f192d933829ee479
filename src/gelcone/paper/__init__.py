"""The source paper, J. Vib. Control, doi 10.1177/10775463261460015: its figures redrawn, its claims checked.

`presets` holds the parameter sets, `studies` computes, `figures` draws the studies, `claims` reads numbers off them,
`verdicts` judges the numbers by stated rules, `run` computes, draws and caches, and `report` writes a page on it all.
"""
