"""Attacks on what taut promises: `make attack`, see docs/reliability.md.

An attack is a class in a module of this package: it makes a case from a seed, and judges it (:mod:`frame`).
Each runs in a process of its own with bounded memory and time (:mod:`worker`); what fails is made smaller
(:mod:`shrink`) and written below out/attack (:mod:`campaign`).
"""
