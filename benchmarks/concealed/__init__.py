"""A virtual laboratory that films a cloth with something concealed in it.

Writes recording bundles (`sim1.recordings/1`) of a baseline cloth with one effect, two or none on top, and beside them, in
files of their own, the truth. It shares no code with the diagnosis that is tested on its bundles: explicit integration
in double precision, a staggered grid instead of triangles, a mesh twice as fine per side, and its own effect formulas.
"""
