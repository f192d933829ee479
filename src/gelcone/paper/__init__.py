"""The source paper, J. Vib. Control, doi 10.1177/10775463261460015: its figures redrawn, its claims checked.

`presets` holds the parameter sets, `studies` computes, `figures` draws the studies, `claims` reads numbers off them,
`verdicts` judges the numbers by stated rules, `run` keeps what is done, and `report` writes one page of it all.
"""
