"""Search, verification and classification of the attractor of a motion.

`search` follows motions until they return or their time is up; `cycle` computes the periodic orbit by Newton's method,
with its smallest period, symmetry and multipliers; `lifetime` distinguishes lasting from transient chaos by nearby
starts; `classification` names the regime and gives the evidence.
"""
