"""The attractor that a motion settles on: found, verified and named in one place, for every analysis that asks.

`search` follows motions until they return, or patience ends; `cycle` computes the periodic orbit there by Newton's
method, with its smallest period, its symmetry and its multipliers; `lifetime` parts chaos that lasts from chaos that
ends by starts nearby; `classification` names the regime, with the evidence for it.
"""
